//! Which of the offered media types a client would like best (RFC 9110, 12.5.1).

use crate::problem::Problem;
use axum::http::{HeaderMap, StatusCode, header};

/// The first of `offered` that the header `Accept` likes best; without the header, the first.
///
/// # Errors
/// 406 when the client takes none of them.
pub fn choose<T: Copy>(
    headers: &HeaderMap,
    offered: &[T],
    media_type: impl Fn(T) -> &'static str,
) -> Result<T, Problem> {
    let lines = headers.get_all(header::ACCEPT).iter().filter_map(|line| line.to_str().ok());
    let ranges: Vec<Range> = lines.flat_map(|line| line.split(',')).filter_map(parse).collect();
    let mut best: Option<(Liking, T)> = None;
    for &one in offered {
        let liking = liking(&ranges, media_type(one));
        if liking.q > 0 && best.is_none_or(|(most, _)| liking > most) {
            best = Some((liking, one));
        }
    }
    best.map(|(_, one)| one).ok_or_else(|| {
        let offered: Vec<_> = offered.iter().map(|&one| media_type(one)).collect();
        Problem::new(StatusCode::NOT_ACCEPTABLE, format!("available: {}", offered.join(", ")))
    })
}

/// One member of the header: `image/png;q=0.5`.
struct Range<'a> {
    name: &'a str,
    q: u16,
}

/// How much a media type is liked; of equal weights, the one that was named more exactly wins.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Liking {
    /// Thousandths.
    q: u16,
    /// 0 for `*/*`, 1 for `image/*`, 2 for `image/png`.
    exactness: u8,
}

fn parse(member: &str) -> Option<Range<'_>> {
    let mut parts = member.split(';').map(str::trim);
    let name = parts.next().filter(|name| !name.is_empty())?;
    let mut q = 1000;
    for part in parts {
        let Some((key, value)) = part.split_once('=') else { continue };
        if key.trim().eq_ignore_ascii_case("q") {
            let weight: f32 = value.trim().parse().ok()?;
            q = (weight.clamp(0.0, 1.0) * 1000.0) as u16;
        }
    }
    Some(Range { name, q })
}

/// The most exact range that matches decides, so that `image/png;q=0, image/*` excludes PNG.
fn liking(ranges: &[Range], media_type: &str) -> Liking {
    if ranges.is_empty() {
        return Liking { q: 1000, exactness: 0 };
    }
    let matching = ranges.iter().filter_map(|range| {
        exactness(range.name, media_type).map(|exactness| (exactness, range.q))
    });
    let (exactness, q) = matching.max().unwrap_or((0, 0));
    Liking { q, exactness }
}

fn exactness(range: &str, media_type: &str) -> Option<u8> {
    if range == "*/*" || range == "*" {
        return Some(0);
    }
    if range.eq_ignore_ascii_case(media_type) {
        return Some(2);
    }
    let family = range.strip_suffix("/*")?;
    let (own, _) = media_type.split_once('/')?;
    own.eq_ignore_ascii_case(family).then_some(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OFFERED: [&str; 4] = ["image/png", "image/jpeg", "image/webp", "application/x-npy"];

    fn chosen(accept: &[&str]) -> Option<&'static str> {
        let mut headers = HeaderMap::new();
        for line in accept {
            headers.append(header::ACCEPT, line.parse().unwrap());
        }
        choose(&headers, &OFFERED, |name| name).ok()
    }

    #[test]
    fn without_the_header_the_first_is_chosen() {
        assert_eq!(chosen(&[]), Some("image/png"));
        assert_eq!(chosen(&[""]), Some("image/png"));
    }

    #[test]
    fn wildcards_leave_the_choice_to_the_order() {
        assert_eq!(chosen(&["*/*"]), Some("image/png"));
        assert_eq!(chosen(&["image/*"]), Some("image/png"));
        assert_eq!(chosen(&["application/*"]), Some("application/x-npy"));
    }

    #[test]
    fn weights_decide() {
        assert_eq!(chosen(&["image/png;q=0.5, image/jpeg"]), Some("image/jpeg"));
        assert_eq!(chosen(&["*/*;q=0.1", "IMAGE/WEBP ; Q=0.2"]), Some("image/webp"));
        assert_eq!(chosen(&["image/avif,image/webp,*/*;q=0.8"]), Some("image/webp"));
    }

    #[test]
    fn of_equal_weights_the_exact_name_wins() {
        assert_eq!(chosen(&["*/*, image/jpeg"]), Some("image/jpeg"));
    }

    #[test]
    fn weight_zero_excludes() {
        assert_eq!(chosen(&["image/png;q=0, image/*"]), Some("image/jpeg"));
        assert_eq!(chosen(&["*/*;q=0"]), None);
    }

    #[test]
    fn nothing_that_matches_is_refused() {
        assert_eq!(chosen(&["text/html"]), None);
        assert_eq!(chosen(&["image/pn"]), None);
    }
}
