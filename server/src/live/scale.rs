//! How large a draft may be so that it comes in time.
//!
//! A draft takes what its pixels take, nearly; so the last one says how many there is time for. Between two sizes little
//! is gained and everything that was kept for the old size is lost: sizes are few, and one grows only when it would
//! surely fit.

use std::time::Duration;

/// From a view to its picture, so that no hand notices: two frames of a screen of 60 Hz.
pub const BUDGET: Duration = Duration::from_millis(33);

/// What of it the passes and the encoder may take: the rest is for the way there and back.
const OF_PASSES: f64 = 0.85;

/// A size that would take more of that than this is not grown to.
const SURELY: f64 = 0.85;

/// Sizes, as shares of a picture's sides: each has seven tenths of the pixels of the one before.
const SCALES: [f64; 9] = [1.0, 0.84, 0.71, 0.59, 0.5, 0.42, 0.35, 0.3, 0.25];

/// Half the sides of so many pixels are the smallest draft: below that every fog is mush. Larger pictures, on screens
/// with fine pixels, may shrink further.
const WHOLE_PIXELS: f64 = 800.0 * 600.0;

/// What a coarser draft takes of the time of another of its size, at least.
const HASTY: f64 = 0.65;

/// The size of the next draft, and whether it is coarser than others, which comes last.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scale {
    place: usize,
    is_hasty: bool,
}

impl Scale {
    /// As a share of the picture's sides.
    pub fn share(self) -> f64 {
        SCALES[self.place]
    }

    /// Whether it is to be coarser than others of its size.
    pub fn is_hasty(self) -> bool {
        self.is_hasty
    }

    /// Learns from a draft of this size of a picture of so many pixels; `is_typical` says that it took what drafts of a
    /// moving camera take.
    pub fn learn(&mut self, took: Duration, is_typical: bool, pixels: f64) {
        let budget = BUDGET.as_secs_f64() * OF_PASSES;
        let took = took.as_secs_f64();
        let takes = |place: usize| took * (SCALES[place] / self.share()).powi(2);
        if took > budget {
            let least = 0.5 * (WHOLE_PIXELS / pixels).sqrt().min(1.0);
            let last = SCALES.iter().rposition(|share| *share >= least).unwrap_or_default();
            let fits = (self.place..=last).find(|place| takes(*place) <= budget);
            self.is_hasty |= fits.is_none();
            self.place = fits.unwrap_or(last.max(self.place));
        } else if is_typical && self.is_hasty {
            self.is_hasty = took > SURELY * HASTY * budget;
        } else if is_typical && self.place > 0 && takes(self.place - 1) <= SURELY * budget {
            self.place -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws pictures of so many pixels with a machine that takes so long for a whole one.
    fn settled(whole_ms: f64, pixels: f64) -> f64 {
        let mut scale = Scale::default();
        for _ in 0..20 {
            let took = Duration::from_secs_f64(whole_ms / 1e3 * scale.share().powi(2));
            scale.learn(took, true, pixels);
        }
        scale.share()
    }

    #[test]
    fn the_largest_size_that_comes_in_time_is_drawn() {
        let settled = |whole_ms| settled(whole_ms, WHOLE_PIXELS);
        assert_eq!(settled(10.0), 1.0);
        assert_eq!(settled(26.0), 1.0);
        assert_eq!(settled(30.0), 0.84);
        assert_eq!(settled(70.0), 0.59);
        // Never smaller than half, however slow the machine is.
        assert_eq!(settled(1000.0), 0.5);
    }

    #[test]
    fn what_is_as_small_as_may_be_and_still_late_is_coarser() {
        let mut scale = Scale::default();
        let mut learn = |ms| {
            scale.learn(Duration::from_millis(ms), true, WHOLE_PIXELS);
            (scale.share(), scale.is_hasty())
        };
        assert_eq!(learn(200), (0.5, true));
        assert_eq!(learn(40), (0.5, true));
        // Not so much faster that others of its size would come in time.
        assert_eq!(learn(25), (0.5, true));
        assert_eq!(learn(15), (0.5, false));
        assert_eq!(learn(15), (0.59, false));
        assert_eq!(learn(29), (0.5, false));
    }

    #[test]
    fn a_picture_of_more_pixels_may_shrink_further() {
        assert_eq!(settled(1000.0, WHOLE_PIXELS / 4.0), 0.5);
        assert_eq!(settled(1000.0, 2.0 * WHOLE_PIXELS), 0.42);
        assert_eq!(settled(1000.0, 4.0 * WHOLE_PIXELS), 0.25);
        assert_eq!(settled(70.0, 4.0 * WHOLE_PIXELS), 0.59);
    }

    #[test]
    fn what_was_kept_does_not_make_it_grow() {
        let mut scale = Scale::default();
        scale.learn(Duration::from_millis(200), true, WHOLE_PIXELS);
        assert_eq!(scale.share(), 0.5);
        scale.learn(Duration::from_millis(1), false, WHOLE_PIXELS);
        assert_eq!(scale.share(), 0.5);
        // First as fine as others, then larger.
        scale.learn(Duration::from_millis(1), true, WHOLE_PIXELS);
        assert_eq!((scale.share(), scale.is_hasty()), (0.5, false));
        scale.learn(Duration::from_millis(1), true, WHOLE_PIXELS);
        assert!(scale.share() > 0.5);
    }
}
