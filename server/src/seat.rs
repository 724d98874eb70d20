//! A place among the connections, for as long as somebody sits there.

use std::any::Any;
use std::sync::Arc;

/// What is held while a conversation lasts. Whoever goes on with a connection as something else than HTTP keeps a copy.
#[derive(Clone)]
pub struct Seat(
    #[expect(dead_code, reason = "it counts until it is dropped")] Arc<dyn Any + Send + Sync>,
);

impl Seat {
    /// Holds something until the last copy is gone.
    pub fn holding(held: impl Any + Send + Sync) -> Self {
        Self(Arc::new(held))
    }
}
