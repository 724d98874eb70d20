//! Work on all tiles of a picture.

use crate::frame::context::Context;
use crate::progress::Interrupted;
use rayon::prelude::*;

/// What is made of so many tiles, unless the job ends: then the rest is `blank`, which lets every
/// tile be written at its place.
pub fn tiles<T: Clone + Send + Sync>(
    context: &Context,
    count: usize,
    blank: &T,
    work: impl Fn(usize) -> T + Sync + Send,
) -> Result<Vec<T>, Interrupted> {
    /// Tiles that one thread takes at once: inside its pool a job would be cut in a few pieces only,
    /// and threads would wait for the slowest.
    const AT_ONCE: usize = 8;
    let is_over = || context.job.progress.is_over();
    let tile = |index| if is_over() { blank.clone() } else { work(index) };
    let done = (0..count).into_par_iter().with_max_len(AT_ONCE).map(tile).collect();
    context.job.progress.check().map(|()| done)
}
