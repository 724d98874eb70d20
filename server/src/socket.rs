//! A client's socket, with three manners that hyper does not have.
//!
//! hyper answers what it cannot read as HTTP with a bare status; here such an answer gets the body
//! that all refusals have. And a socket that is closed while the client still sends is reset by
//! the system, which may cost the client the answer that it was about to read; so it is emptied
//! for a moment first. And a client that does not take its answer is left.

use crate::pace::{Least, Pace};
use crate::problem::{CONTENT_TYPE, Problem};
use axum::http::StatusCode;
use std::io::{self, IoSlice};
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, ReadBuf};
use tokio::net::TcpStream;

/// How long a client may go on sending after it was answered.
const LINGER: Duration = Duration::from_secs(2);

/// A client that has sent nothing for this long has stopped.
const SILENCE: Duration = Duration::from_millis(250);

/// The least of an answer that a client must take meanwhile. The system takes bytes off our hands by
/// the third of its buffer, so that this is two such pieces.
const LEAST: Least = Least { bytes: 320 << 10, window: Duration::from_secs(10) };

/// Bytes of an answer that the system holds for each client; it takes them twice over for itself.
pub const SEND_BUFFER_BYTES: u32 = 256 << 10;

/// A socket that hyper borrows for as long as it serves.
pub struct Socket {
    stream: TcpStream,
    /// How fast the client takes its answer.
    pace: Pace,
    /// The status of hyper's own refusal, held back until [`Socket::finish`].
    refused: Option<StatusCode>,
}

impl Socket {
    /// Takes over a client's socket.
    pub fn new(stream: TcpStream) -> Self {
        Self { stream, pace: Pace::new(LEAST), refused: None }
    }

    /// Says what is still to be said, and closes without losing it.
    ///
    /// # Errors
    /// When the client is gone.
    pub async fn finish(mut self) -> io::Result<()> {
        if let Some(status) = self.refused {
            let refusal = refusal(status);
            tokio::time::timeout(LINGER, self.stream.write_all(&refusal)).await??;
        }
        self.stream.shutdown().await?;
        let mut rest = [0; 16 << 10];
        let drain = async {
            let mut more = async || {
                let read = tokio::time::timeout(SILENCE, self.stream.read(&mut rest));
                matches!(read.await, Ok(Ok(bytes)) if bytes > 0)
            };
            while more().await {}
        };
        // Whoever still sends after this time has had the chance to read.
        let _ = tokio::time::timeout(LINGER, drain).await;
        Ok(())
    }

    /// What a write came to, which must not take too long.
    fn paced(
        &mut self,
        cx: &mut Context<'_>,
        written: Poll<io::Result<usize>>,
    ) -> Poll<io::Result<usize>> {
        match written {
            Poll::Ready(Ok(bytes)) => self.pace.moved(bytes),
            Poll::Ready(Err(_)) => {}
            Poll::Pending => {
                ready!(self.pace.poll_too_slow(cx));
                // What the system still holds for this client is dropped with the socket.
                self.stream.set_zero_linger()?;
                return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
            }
        }
        written
    }

    fn hold_back(&mut self, bytes: &[u8]) -> bool {
        self.refused = self.refused.or_else(|| bare_refusal(bytes));
        self.refused.is_some()
    }
}

/// The status, if these bytes are a refusal without a body. The routes never send such a one.
fn bare_refusal(bytes: &[u8]) -> Option<StatusCode> {
    let status = bytes.strip_prefix(b"HTTP/1.1 ").or(bytes.strip_prefix(b"HTTP/1.0 "))?.get(..3)?;
    let status = StatusCode::from_bytes(status).ok().filter(StatusCode::is_client_error)?;
    let empty = b"content-length: 0\r\n";
    bytes.windows(empty.len()).any(|window| window == empty).then_some(status)
}

fn refusal(status: StatusCode) -> Vec<u8> {
    let detail = match status {
        StatusCode::URI_TOO_LONG => "the address is too long",
        StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE => "the headers are too large",
        _ => "this is not an HTTP/1.1 request",
    };
    let problem = Problem::new(status, detail);
    let body = problem.json();
    let head = format!(
        "HTTP/1.1 {} {}\r\ncontent-type: {CONTENT_TYPE}\r\nx-content-type-options: nosniff\r\n\
         connection: close\r\ncontent-length: {}\r\n\r\n",
        status.as_u16(),
        status.canonical_reason().unwrap_or_default(),
        body.len()
    );
    [head.into_bytes(), body].concat()
}

impl AsyncRead for Socket {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(cx, buffer)
    }
}

impl AsyncWrite for Socket {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        if self.hold_back(bytes) {
            return Poll::Ready(Ok(bytes.len()));
        }
        let written = Pin::new(&mut self.stream).poll_write(cx, bytes);
        self.paced(cx, written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        slices: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        if slices.first().is_some_and(|first| self.hold_back(first)) {
            return Poll::Ready(Ok(slices.iter().map(|slice| slice.len()).sum()));
        }
        let written = Pin::new(&mut self.stream).poll_write_vectored(cx, slices);
        self.paced(cx, written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    /// Comes when a whole answer, or a part that was waited for, is written.
    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.pace.rest();
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    /// Not yet: [`Socket::finish`] does it.
    fn poll_shutdown(self: Pin<&mut Self>, _cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_refusals_without_a_body_are_held_back() {
        let bare = b"HTTP/1.1 400 Bad Request\r\nconnection: close\r\ncontent-length: 0\r\n\r\n";
        assert_eq!(bare_refusal(bare), Some(StatusCode::BAD_REQUEST));
        assert_eq!(bare_refusal(b"HTTP/1.1 404 Not Found\r\ncontent-length: 10\r\n\r\n"), None);
        assert_eq!(bare_refusal(b"HTTP/1.1 200 OK\r\ncontent-length: 0\r\n\r\n"), None);
        assert_eq!(bare_refusal(b"\x89PNG"), None);
    }
}
