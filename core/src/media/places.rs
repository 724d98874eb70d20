//! Where a fog changes along the axes: what a table over space must resolve.

use super::vertical::Profile;

/// A stretch of an axis with the steps that it needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Where it begins [m].
    pub from: f64,
    /// Where it ends [m].
    pub to: f64,
    /// The steps [m].
    pub step: f64,
}

/// The stretches of the three axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Places(pub [Vec<Stretch>; 3]);

impl Places {
    /// Adds a stretch of an axis.
    pub fn add(&mut self, axis: usize, from: f64, to: f64, step: f64) {
        if from < to && step > 0.0 && (to - from).is_finite() {
            self.0[axis].push(Stretch { from, to, step });
        }
    }

    /// Adds what a profile of heights needs, of that extinction [1/m].
    pub fn add_profile(&mut self, profile: Profile, beta: f64) {
        match profile {
            Profile::Uniform => {}
            Profile::Slab { min, max } => {
                let height = max - min;
                self.add(1, min, max, height / 16.0);
                // From beside a boundary light comes through ever less fog: its share has a cusp there.
                let thin = (0.1 * height).min(0.5 / beta.max(1e-300));
                for [from, to] in [[min, min + thin], [max - thin, max]] {
                    self.add(1, from, to, thin / 10.0);
                }
            }
            Profile::Exponential { base, falloff } => {
                let scale = 1.0 / falloff.max(1e-12);
                for [from, to, step] in [[0.0, 1.0, 0.08], [1.0, 4.0, 0.3], [4.0, 15.0, 1.5]] {
                    self.add(1, base + from * scale, base + to * scale, step * scale);
                }
                // Below, light comes through ever more fog until there is none left.
                let dark = (10.0 / beta.max(1e-300)).min(1e3 * scale);
                self.add(1, base - dark, base, dark / 12.0);
            }
        }
    }

    /// Adds room around an axis's stretches, over which what they hide of a sky fades.
    pub fn widen(&mut self, axis: usize) {
        let stretches = &self.0[axis];
        let from = stretches.iter().map(|own| own.from).fold(f64::INFINITY, f64::min);
        let to = stretches.iter().map(|own| own.to).fold(f64::NEG_INFINITY, f64::max);
        let extent = to - from;
        // Ever longer steps, up to where it fills less than a hundredth of the directions.
        let mut reach = 0.0;
        for step in [0.15, 0.3, 0.6, 1.2, 2.4] {
            let next = reach + step;
            self.add(axis, to + reach * extent, to + next * extent, step * extent);
            self.add(axis, from - next * extent, from - reach * extent, step * extent);
            reach = next;
        }
    }

    /// Places on every axis, ascending [m], that follow the finest steps asked for; as many as all three come to no
    /// more than `most`. Where nothing is asked for there is one. `None` where more than `needed` are asked for: so few
    /// would tell little of them.
    pub fn knots(&self, most: usize, needed: usize) -> Option<[Vec<f64>; 3]> {
        /// Fewer than these do not bend.
        const FEWEST: f64 = 4.0;
        let needs = self.0.each_ref().map(|stretches| Need::new(stretches));
        let mut counts = needs.each_ref().map(|need| need.as_ref().map_or(1.0, Need::knots));
        if counts.iter().product::<f64>() > needed as f64 {
            return None;
        }
        for _ in 0..8 {
            let all: f64 = counts.iter().product();
            if all <= most as f64 {
                break;
            }
            let wide = counts.iter().filter(|count| **count > FEWEST).count().max(1);
            let share = (most as f64 / all).powf(1.0 / wide as f64);
            for count in counts.iter_mut().filter(|count| **count > FEWEST) {
                *count = (*count * share).max(FEWEST);
            }
        }
        Some(std::array::from_fn(|axis| match &needs[axis] {
            Some(need) => need.spread(counts[axis].floor() as usize),
            None => vec![0.0],
        }))
    }
}

/// How many steps an axis needs from place to place.
struct Need {
    ends: Vec<f64>,
    /// Steps from the first end to each.
    sums: Vec<f64>,
}

impl Need {
    /// `None` where nothing is asked for.
    fn new(stretches: &[Stretch]) -> Option<Self> {
        /// Ends that are told apart.
        const MOST: usize = 512;
        let mut all: Vec<_> = stretches.iter().flat_map(|own| [own.from, own.to]).collect();
        all.sort_unstable_by(f64::total_cmp);
        all.dedup();
        if all.len() < 2 {
            return None;
        }
        let parts = (all.len() - 1).min(MOST);
        let ends: Vec<_> = (0..=parts).map(|i| all[i * (all.len() - 1) / parts]).collect();
        let mut density = vec![0.0f64; parts];
        for own in stretches {
            let first = ends.partition_point(|end| *end <= own.from).saturating_sub(1);
            for (part, density) in density.iter_mut().enumerate().skip(first) {
                if ends[part] >= own.to {
                    break;
                }
                *density = density.max(1.0 / own.step);
            }
        }
        let mut sums = vec![0.0];
        for (part, density) in density.iter().enumerate() {
            sums.push(sums[part] + density * (ends[part + 1] - ends[part]));
        }
        Some(Self { ends, sums })
    }

    fn whole(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    fn knots(&self) -> f64 {
        (self.whole().ceil() + 1.0).max(2.0)
    }

    /// So many places with as much need between each and the next.
    fn spread(&self, count: usize) -> Vec<f64> {
        let step = self.whole() / (count.max(2) - 1) as f64;
        let at = |i: usize| {
            let sum = i as f64 * step;
            let part = self.sums.partition_point(|own| *own < sum).clamp(1, self.ends.len() - 1);
            let [before, behind] = [self.sums[part - 1], self.sums[part]];
            let share = if behind > before { (sum - before) / (behind - before) } else { 0.0 };
            self.ends[part - 1] + share.clamp(0.0, 1.0) * (self.ends[part] - self.ends[part - 1])
        };
        let mut knots: Vec<_> = (0..count.max(2)).map(at).collect();
        knots.dedup();
        knots
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Knots stand closest where the finest steps are asked for, and their number is kept.
    #[test]
    fn knots_follow_the_need() {
        let mut places = Places::default();
        places.add(0, 0.0, 10.0, 1.0);
        places.add(0, 4.0, 5.0, 0.1);
        let [x, y, z] = places.knots(1000, 1000).expect("few");
        assert_eq!((y.len(), z.len()), (1, 1));
        assert_eq!((x[0], x[x.len() - 1]), (0.0, 10.0));
        assert!((18..=22).contains(&x.len()), "{}", x.len());
        assert!(x.iter().filter(|x| (4.0..=5.0).contains(*x)).count() >= 9);
        assert!(x.windows(2).all(|pair| pair[0] < pair[1]));
        (1..3).for_each(|axis| places.add(axis, 0.0, 10.0, 0.1));
        assert_eq!(places.knots(1000, 1000), None);
        let counts = places.knots(1000, 1 << 20).expect("enough").map(|knots| knots.len());
        assert!(counts.iter().product::<usize>() <= 1000, "{counts:?}");
    }
}
