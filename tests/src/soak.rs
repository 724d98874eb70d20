//! How long a soak lasts.

/// So many rounds of a soak: a twentieth of `all`, or all where all cases are asked for.
pub fn rounds(all: usize) -> usize {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse::<usize>().ok());
    (all * cases.unwrap_or(5000) / 100_000).max(1)
}
