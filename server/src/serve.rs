//! `fogbank serve`: from the options to a listening socket, and back down in order.

use crate::app::{App, Phase};
use crate::cli::ServeArgs;
use crate::commands::Failure;
use crate::connections::Connections;
use crate::log::Log;
use crate::socket::SEND_BUFFER_BYTES;
use crate::store::Store;
use std::io::{self, Write};
use std::net::SocketAddr;
use std::path::Path;
use std::time::Duration;
use tokio::net::{TcpListener, TcpSocket};
use tokio::sync::watch;

/// How long the last answers may take to be sent.
const TIME_TO_SAY_SO: Duration = Duration::from_secs(2);

/// Clients that the system keeps waiting until they are accepted.
const BACKLOG: u32 = 1024;

/// Serves until the process is asked to stop.
///
/// # Errors
/// When the data directory or the address cannot be used.
pub fn serve(options: ServeArgs) -> Result<(), Failure> {
    let log = Log::to_stderr().map_err(|error| Failure::new("log", error))?;
    let store = open_store(options.data_dir.as_deref())?;
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build();
    let runtime = runtime.map_err(|error| Failure::new("runtime", error))?;
    let result = runtime.block_on(run(options, store));
    // A body that is still being parsed has nobody to answer to any more.
    runtime.shutdown_background();
    log.end();
    result
}

/// The scenes in a directory, which is made if need be; without one, new scenes in memory.
fn open_store(directory: Option<&Path>) -> Result<Store, Failure> {
    match directory {
        Some(directory) => tracing::info!("scenes are kept in {}", directory.display()),
        None => {
            tracing::info!(
                "scenes are kept in memory, and end with the server: --data-dir keeps them"
            );
        }
    }
    let place = directory.map_or_else(|| "memory".into(), Path::to_string_lossy);
    Store::open(directory).map_err(|failure| Failure::new(place, failure))
}

async fn run(options: ServeArgs, store: Store) -> Result<(), Failure> {
    let place = options.listen.clone();
    let failure = |error: io::Error| Failure::new(format_args!("cannot listen on {place}"), error);
    let listener = listen(&place).await.map_err(failure)?;
    let address = listener.local_addr().map_err(failure)?;
    let drain = Duration::from_secs_f64(options.drain_s.unwrap_or(options.deadline_s));
    let (phase, phases) = watch::channel(Phase::Serving);
    let app =
        App::start(options, store, phases).map_err(|error| Failure::new("renderer", error))?;
    let mut signals = Signals::new().map_err(|error| Failure::new("signals", error))?;
    announce(address);
    let mut connections = Connections::new(app);
    tokio::select! {
        () = connections.accept(listener) => {}
        () = signals.next() => {}
    }
    tracing::info!("stopping");
    phase.send_replace(Phase::Draining);
    tokio::select! {
        () = connections.ended() => return Ok(()),
        () = tokio::time::sleep(drain) => {}
        // Asked again, it does not wait any longer.
        () = signals.next() => {}
    }
    phase.send_replace(Phase::Over);
    if tokio::time::timeout(TIME_TO_SAY_SO, connections.ended()).await.is_err() {
        tracing::warn!("answers were cut off");
    }
    Ok(())
}

/// Listens on the first of the addresses that a name stands for and that can be used.
async fn listen(place: &str) -> io::Result<TcpListener> {
    let mut result = Err(io::ErrorKind::AddrNotAvailable.into());
    for address in tokio::net::lookup_host(place).await? {
        result = listen_on(address);
        if result.is_ok() {
            break;
        }
    }
    result
}

fn listen_on(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4() } else { TcpSocket::new_v6() }?;
    // A port that a server has just left may be used again.
    #[cfg(unix)]
    socket.set_reuseaddr(true)?;
    // Every accepted socket gets the same.
    socket.set_send_buffer_size(SEND_BUFFER_BYTES)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)
}

fn announce(address: SocketAddr) {
    if !address.ip().is_loopback() {
        tracing::warn!("whoever can reach {address} can use this server: it asks for no password");
    }
    // A closed standard output is no reason not to serve.
    let mut out = io::stdout().lock();
    let _ = writeln!(out, "listening on http://{address}").and_then(|()| out.flush());
}

/// What asks the process to stop.
#[cfg(unix)]
struct Signals {
    terminate: tokio::signal::unix::Signal,
    interrupt: tokio::signal::unix::Signal,
}

#[cfg(unix)]
impl Signals {
    /// Listens from now on.
    fn new() -> io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
        let (terminate, interrupt) =
            (signal(SignalKind::terminate())?, signal(SignalKind::interrupt())?);
        Ok(Self { terminate, interrupt })
    }

    /// Ends at the next one.
    async fn next(&mut self) {
        tokio::select! {
            _ = self.terminate.recv() => {}
            _ = self.interrupt.recv() => {}
        }
    }
}

#[cfg(not(unix))]
struct Signals;

#[cfg(not(unix))]
impl Signals {
    fn new() -> io::Result<Self> {
        Ok(Self)
    }

    async fn next(&mut self) {
        tokio::signal::ctrl_c().await.unwrap_or_default();
    }
}
