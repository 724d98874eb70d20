//! Parts of a ray.

/// What is left of a part where some others are taken out, which are given in ascending order [m].
pub fn without([from, to]: [f64; 2], taken: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut left = Vec::with_capacity(taken.len() + 1);
    let mut begin = from;
    for [first, last] in taken {
        if *first > begin {
            left.push([begin, first.min(to)]);
        }
        begin = begin.max(*last);
        if begin >= to {
            break;
        }
    }
    left.push([begin, to]);
    left.retain(|[from, to]| from < to);
    left
}

#[cfg(test)]
mod tests {
    use super::without;

    #[test]
    fn what_is_taken_out_is_out() {
        let taken = [[-1.0, 1.0], [2.0, 3.0], [9.0, 12.0]];
        assert_eq!(without([0.0, 10.0], &taken), [[1.0, 2.0], [3.0, 9.0]]);
        assert_eq!(without([0.0, 10.0], &[]), [[0.0, 10.0]]);
        assert_eq!(without([0.0, 10.0], &[[0.0, 10.0]]), [[0.0; 2]; 0]);
        assert_eq!(without([4.0, 5.0], &taken), [[4.0, 5.0]]);
    }
}
