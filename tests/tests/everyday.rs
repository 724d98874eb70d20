//! `auto` on what a newcomer types: haze, a few blobs, a lamp, and an open sky.

use fogbank_tests::everyday::{Exact, SCENES, Seen, everyday};
use fogbank_tests::trials::Use;

/// Pictures are small, so that every pixel of all scenes can be compared.
const HEIGHT: u32 = 60;

#[test]
fn pictures_under_an_open_sky_have_no_steps() {
    for number in 0..SCENES {
        let exact = Exact::new(&everyday(number), HEIGHT);
        // A step of 1 % is the least that the eye tells from none. For the eye the smallest cells are two pixels
        // wide, and where blobs' tails end within one there is a step in what is a hundredth as bright as the rest.
        for (wanted, most) in [(Use::Numbers, 0.01), (Use::Screen, 0.15)] {
            let Seen { errors: [median, p95, _], step } = exact.measure(wanted);
            let what =
                format!("scene {number}, {wanted:?}: median {median}, p95 {p95}, step {step}");
            assert!(step <= most && median <= 0.003 && p95 <= 0.03, "{what}");
        }
    }
}

/// What pictures are held against is held against the integral.
#[test]
fn probes_under_an_open_sky_are_right() {
    for number in 0..SCENES {
        let [median, p95, most] = Exact::new(&everyday(number), 24).of_probes(12);
        // The rules that a probe compares differ by 1e-4 at most.
        let what = format!("scene {number}: median {median}, p95 {p95}, most {most}");
        assert!(median <= 1e-4 && most <= 2e-3, "{what}");
    }
}
