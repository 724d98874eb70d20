//! Horner's scheme for a polynomial of three variables: its monomials come in falling order of their powers, so
//! that each is added to what is there before that is multiplied by the step to the next.

use super::monomial::Monomial;
use crate::num::Num;
use crate::vector::V3;

/// One monomial of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    coefficient: f64,
    /// How often the sum over w is multiplied by w then, that over v by v and that over u by u.
    times: [u8; 3],
    /// Of these sums how many end and are added to the next outer one.
    folds: u8,
}

/// A polynomial as it is summed up.
#[derive(Clone, Debug, PartialEq)]
pub struct Horner(Vec<Step>);

impl Horner {
    /// The sum of some monomials.
    pub fn new(monomials: &[Monomial]) -> Self {
        let mut sorted = monomials.to_vec();
        sorted.sort_by_key(|one| std::cmp::Reverse(one.powers));
        sorted.dedup_by(|next, kept| {
            let same = next.powers == kept.powers;
            kept.coefficient += if same { next.coefficient } else { 0.0 };
            same
        });
        let next = sorted.iter().skip(1).map(|one| Some(one.powers)).chain([None]);
        let steps = sorted.iter().zip(next).map(|(one, next)| Step::new(one, next));
        Self(steps.collect())
    }

    /// Monomials that it has.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Bytes that it takes besides its own.
    pub fn size(&self) -> usize {
        size_of_val(self.0.as_slice())
    }

    /// Σ c u^p v^q w^r.
    #[inline(always)]
    pub fn value<N: Num>(&self, at: V3<N>) -> N {
        let zero = at.x.lit(0.0);
        let (mut inner, mut middle, mut outer) = (zero, zero, zero);
        for Step { coefficient, times: [z, y, x], folds } in &self.0 {
            inner = raised(inner + zero.lit(*coefficient), at.z, *z);
            if *folds > 0 {
                middle = raised(middle + inner, at.y, *y);
                inner = zero;
            }
            if *folds > 1 {
                outer = raised(outer + middle, at.x, *x);
                middle = zero;
            }
        }
        outer
    }

    /// As the shader reads it: two numbers a monomial.
    pub fn words(&self) -> impl Iterator<Item = f32> {
        self.0.iter().flat_map(|Step { coefficient, times: [z, y, x], folds }| {
            let digits = [*folds, *x, *y, *z].map(u32::from);
            // Powers are below 16.
            let packed = digits.into_iter().fold(0, |all, digit| 16 * all + digit);
            [*coefficient as f32, packed as f32]
        })
    }
}

impl Step {
    fn new(one: &Monomial, next: Option<[u8; 3]>) -> Self {
        let [p, q, r] = one.powers;
        let (times, folds) = match next {
            Some([u, v, w]) if (u, v) == (p, q) => ([r - w, 0, 0], 0),
            Some([u, v, _]) if u == p => ([r, q - v, 0], 1),
            Some([u, ..]) => ([r, q, p - u], 2),
            None => ([r, q, p], 2),
        };
        Self { coefficient: one.coefficient, times, folds }
    }
}

/// A sum times a power of a variable.
#[inline(always)]
fn raised<N: Num>(mut sum: N, variable: N, power: u8) -> N {
    for _ in 0..power {
        sum = sum * variable;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use glam::DVec3;

    /// It is the sum of its monomials, whatever their order and however often one is named.
    #[test]
    fn scheme_is_the_sum() {
        let mut random = Random::new(3);
        for count in 0..40 {
            let mut power = || random.between(0.0, 5.99) as u8;
            let powers: Vec<_> = (0..count).map(|_| [power(), power(), power()]).collect();
            let of = |powers| Monomial { powers, coefficient: random.between(-1.0, 1.0) };
            let monomials: Vec<_> = powers.into_iter().map(of).collect();
            let at = DVec3::new(0.7, -0.9, 1.1);
            let term = |one: &Monomial| {
                let [p, q, r] = one.powers.map(i32::from);
                one.coefficient * at.x.powi(p) * at.y.powi(q) * at.z.powi(r)
            };
            let sum: f64 = monomials.iter().map(term).sum();
            let value: f64 = Horner::new(&monomials).value(at.into());
            assert!((value - sum).abs() < 1e-12, "{count}: {value} {sum}");
        }
    }
}
