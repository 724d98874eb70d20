//! Writes `THIRD-PARTY.md`.

fn main() -> std::io::Result<()> {
    let place = concat!(env!("CARGO_MANIFEST_DIR"), "/../THIRD-PARTY.md");
    std::fs::write(place, fogbank_tests::licences::third_party())
}
