//! Clients that are too slow: whoever is waited for must move so many bytes in every window of time.

use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::time::{Instant, Sleep, sleep_until};

/// The least that a client must move.
#[derive(Clone, Copy, Debug)]
pub struct Least {
    /// So many bytes …
    pub bytes: usize,
    /// … in every stretch of this length.
    pub window: Duration,
}

/// Watches how fast bytes move, for as long as somebody waits for them.
#[derive(Debug)]
pub struct Pace {
    least: Least,
    moved: usize,
    window: Option<Pin<Box<Sleep>>>,
}

impl Pace {
    /// Nothing is waited for yet.
    pub fn new(least: Least) -> Self {
        Self { least, moved: 0, window: None }
    }

    /// So many bytes came or went.
    pub fn moved(&mut self, bytes: usize) {
        self.moved = self.moved.saturating_add(bytes);
    }

    /// Nothing is waited for any more.
    pub fn rest(&mut self) {
        self.window = None;
    }

    /// Is ready when too few bytes moved in a window; to be asked while one waits.
    pub fn poll_too_slow(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        loop {
            let least = self.least;
            let window = self.window.get_or_insert_with(|| {
                self.moved = 0;
                Box::pin(sleep_until(Instant::now() + least.window))
            });
            ready!(window.as_mut().poll(cx));
            if self.moved < self.least.bytes {
                return Poll::Ready(());
            }
            self.rest();
        }
    }

    /// What `future` comes to, or `None` when too few bytes moved in the meantime.
    pub async fn unless_too_slow<T>(&mut self, future: impl Future<Output = T>) -> Option<T> {
        let mut future = std::pin::pin!(future);
        std::future::poll_fn(|cx| match future.as_mut().poll(cx) {
            Poll::Ready(value) => Poll::Ready(Some(value)),
            Poll::Pending => self.poll_too_slow(cx).map(|()| None),
        })
        .await
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::future::pending;

    fn pace() -> Pace {
        Pace::new(Least { bytes: 10, window: Duration::from_millis(50) })
    }

    #[tokio::test]
    async fn who_stands_still_is_too_slow_and_who_moves_is_not() {
        let mut pace = pace();
        for _ in 0..4 {
            let step = tokio::time::sleep(Duration::from_millis(30));
            assert!(pace.unless_too_slow(step).await.is_some());
            pace.moved(10);
        }
        assert!(pace.unless_too_slow(pending::<()>()).await.is_none());
    }

    #[tokio::test]
    async fn time_counts_only_while_somebody_waits() {
        let mut pace = pace();
        assert!(pace.unless_too_slow(std::future::ready(())).await.is_some());
        tokio::time::sleep(Duration::from_millis(80)).await;
        let step = tokio::time::sleep(Duration::from_millis(1));
        assert!(pace.unless_too_slow(step).await.is_some());
        pace.rest();
        tokio::time::sleep(Duration::from_millis(80)).await;
        let step = tokio::time::sleep(Duration::from_millis(1));
        assert!(pace.unless_too_slow(step).await.is_some());
    }
}
