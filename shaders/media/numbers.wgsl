// What media in closed form have of no fixed length: coefficients of maps, monomials of polynomials. Rows say where
// theirs begin.

#define_import_path fogbank::media::numbers

@group(0) @binding(20) var<storage, read> numbers: array<f32>;

fn at(place: u32) -> f32 {
    return numbers[place];
}
