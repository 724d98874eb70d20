//! The log on standard error. A disk that is full, or a pipe that nobody reads, costs lines of the
//! log and nothing else.

use std::io::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::MakeWriter;

/// Lines that may wait to be written; further ones are lost.
const LINES: usize = 1024;

/// How long the last lines may take to be written.
const TIME_TO_END: Duration = Duration::from_secs(1);

enum Message {
    Line(Vec<u8>),
    /// Everything before it is written once this is dropped.
    End(SyncSender<()>),
}

/// Hands lines over to the thread that writes them.
#[derive(Clone)]
pub struct Log(SyncSender<Message>);

impl Log {
    /// Writes all events of the program to standard error from now on.
    pub fn to_stderr() -> io::Result<Self> {
        let (sender, lines) = sync_channel(LINES);
        std::thread::Builder::new().name("log".into()).spawn(move || write(&lines))?;
        let log = Self(sender);
        let filter = EnvFilter::try_from_env("FOGBANK_LOG");
        let filter = filter.unwrap_or_else(|_| EnvFilter::new("info"));
        tracing_subscriber::fmt().with_env_filter(filter).with_writer(log.clone()).init();
        Ok(log)
    }

    /// Waits until what was said is written, but not for ever.
    pub fn end(self) {
        let (done, ended) = sync_channel(0);
        if self.0.try_send(Message::End(done)).is_ok() {
            // Either nothing comes any more, or nobody takes the lines.
            let _ = ended.recv_timeout(TIME_TO_END);
        }
    }
}

fn write(lines: &Receiver<Message>) {
    for message in lines {
        match message {
            // There is nowhere to say that nothing can be said.
            Message::Line(line) => drop(io::stderr().write_all(&line)),
            Message::End(done) => drop(done),
        }
    }
}

impl MakeWriter<'_> for Log {
    type Writer = Self;

    fn make_writer(&self) -> Self {
        self.clone()
    }
}

/// Takes each event as one line, and never fails.
impl Write for Log {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        // A full channel means that the lines are not taken: this one is lost.
        let _ = self.0.try_send(Message::Line(line.to_vec()));
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_nobody_takes_are_lost_and_nothing_waits_for_them() {
        let (sender, lines) = sync_channel(LINES);
        let mut log = Log(sender);
        for _ in 0..2 * LINES {
            assert_eq!(log.write(b"fog").unwrap(), 3);
        }
        assert_eq!(lines.try_iter().count(), LINES);
        drop(lines);
        assert_eq!(log.write(b"fog").unwrap(), 3);
        log.end();
    }
}
