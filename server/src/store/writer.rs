//! The one thread that writes. It takes what has come meanwhile, commits it in one transaction, shows it and answers
//! all: what was answered is on disk. One write to the disk for many is what makes many a second.

use super::Refusal;
use super::record::Record;
use super::room::Room;
use super::tables::{Outcome, delete, write};
use super::vault::{Failure, Vault};
use std::io;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::thread::JoinHandle;
use tokio::sync::oneshot;

/// Writes of one transaction.
const TOGETHER: usize = 256;

/// What is to be done with a scene.
pub enum Task {
    /// Make a revision durable.
    Write(Box<Record>),
    /// Take it away at this revision; and the key of that request, with what a repeated one must agree in.
    Delete(u64, Option<(String, u64)>),
}

/// A task, whose it is, and who waits for it.
pub struct Order {
    /// The scene.
    pub room: Arc<Room>,
    /// What is to be done.
    pub task: Task,
    /// Hears when it is durable.
    pub done: oneshot::Sender<Result<(), Refusal>>,
}

/// The thread. It is joined when it is let go of, so that nobody writes to what another process may have opened by then.
pub struct Writer {
    orders: Option<mpsc::Sender<Order>>,
    thread: Option<JoinHandle<()>>,
}

impl Writer {
    /// Starts it. It takes what it wrote off the bytes that are `waiting`.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn start(vault: Arc<Vault>, waiting: Arc<AtomicUsize>) -> io::Result<Self> {
        let (orders, come) = mpsc::channel::<Order>();
        let work = move || {
            while let Ok(first) = come.recv() {
                let others = come.try_iter().take(TOGETHER - 1);
                let orders: Vec<_> = std::iter::once(first).chain(others).collect();
                let bytes = orders.iter().map(Order::bytes).sum();
                serve(&vault, orders);
                waiting.fetch_sub(bytes, Ordering::Relaxed);
            }
        };
        let thread = std::thread::Builder::new().name("writer".into()).spawn(work)?;
        Ok(Self { orders: Some(orders), thread: Some(thread) })
    }

    /// Hands an order over.
    ///
    /// # Errors
    /// When the thread has ended.
    pub fn take(&self, order: Order) -> Result<(), Refusal> {
        let sent = self.orders.as_ref().map(|orders| orders.send(order));
        match sent {
            Some(Ok(())) => Ok(()),
            _ => Err(Refusal::Failed("the writer is gone".into())),
        }
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        // Orders that came still are served.
        self.orders = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn serve(vault: &Vault, orders: Vec<Order>) {
    let outcomes = vault.write(|transaction| {
        let each = orders.iter().map(|order| match &order.task {
            Task::Write(record) => write(transaction, record),
            Task::Delete(base, key) => delete(transaction, &order.room.id, *base, key.as_ref()),
        });
        each.collect::<Result<Vec<_>, _>>()
    });
    match outcomes {
        Ok(outcomes) => {
            for (order, outcome) in orders.into_iter().zip(outcomes) {
                let result = match outcome {
                    Outcome::Written => {
                        order.show();
                        Ok(())
                    }
                    Outcome::Stale => {
                        order.room.forget();
                        Err(Refusal::Lost)
                    }
                };
                order.answer(result);
            }
        }
        // One of them may be what does not fit: each for itself, in their order.
        Err(_) if orders.len() > 1 => {
            orders.into_iter().for_each(|order| serve(vault, vec![order]));
        }
        Err(failure) => {
            // Before anybody hears of it: the next write must not begin with what was lost.
            orders.iter().for_each(|order| order.room.forget());
            for order in orders {
                order.answer(Err(failure.clone().into()));
            }
        }
    }
}

impl Order {
    fn bytes(&self) -> usize {
        match &self.task {
            Task::Write(record) => record.change.len(),
            Task::Delete(..) => 0,
        }
    }

    /// Lets readers see it.
    fn show(&self) {
        let head = match &self.task {
            Task::Write(record) => Some(Arc::clone(&record.head)),
            Task::Delete(..) => None,
        };
        self.room.show(head);
    }

    fn answer(self, result: Result<(), Refusal>) {
        // Whoever left does not hear it; what was done is done.
        let _ = self.done.send(result);
    }
}

impl From<Failure> for Refusal {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Full => Self::Full,
            other => Self::Failed(other.to_string()),
        }
    }
}
