//! `fogbank serve`: from the options to a listening socket, and back down in order.

use crate::app::App;
use crate::cli::ServeArgs;
use crate::commands::Failure;
use crate::socket::Socket;
use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::io::{self, Write};
use std::net::SocketAddr;
use std::path::Path;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, watch};
use tracing_subscriber::EnvFilter;

/// How long a client may take to send the head of a request, and stay connected without one.
const HEAD_TIME: Duration = Duration::from_secs(10);

/// How long requests may take to end once the server is asked to stop.
const STOP_TIME: Duration = Duration::from_secs(10);

/// Clients at a time; more wait to be accepted.
const CONNECTIONS: usize = 1024;

/// Serves until the process is asked to stop.
///
/// # Errors
/// When the data directory or the address cannot be used.
pub fn serve(options: ServeArgs) -> Result<(), Failure> {
    log_to_stderr();
    if let Some(directory) = &options.data_dir {
        check_writable(directory).map_err(|error| Failure::new(directory.display(), error))?;
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build();
    let runtime = runtime.map_err(|error| Failure::new("runtime", error))?;
    let result = runtime.block_on(run(options));
    // A body that is still being parsed has nobody to answer to any more.
    runtime.shutdown_background();
    result
}

fn log_to_stderr() {
    let filter = EnvFilter::try_from_env("FOGBANK_LOG").unwrap_or_else(|_| EnvFilter::new("info"));
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(io::stderr).init();
}

/// Makes the directory if need be, and writes a file there to see whether that can be done.
fn check_writable(directory: &Path) -> io::Result<()> {
    std::fs::create_dir_all(directory)?;
    let trial = directory.join(".fogbank-trial");
    std::fs::write(&trial, "")?;
    std::fs::remove_file(trial)
}

async fn run(options: ServeArgs) -> Result<(), Failure> {
    let place = options.listen.clone();
    let failure = |error: io::Error| Failure::new(format_args!("cannot listen on {place}"), error);
    let listener = TcpListener::bind(&place).await.map_err(failure)?;
    let address = listener.local_addr().map_err(failure)?;
    let app = App::start(options).map_err(|error| Failure::new("renderer", error))?;
    let asked_to_stop = stop_signal().map_err(|error| Failure::new("signals", error))?;
    announce(address);
    accept(listener, app.router(), asked_to_stop).await;
    Ok(())
}

fn announce(address: SocketAddr) {
    if !address.ip().is_loopback() {
        tracing::warn!("whoever can reach {address} can use this server: it asks for no password");
    }
    // A closed standard output is no reason not to serve.
    let mut out = io::stdout().lock();
    let _ = writeln!(out, "listening on http://{address}").and_then(|()| out.flush());
}

async fn accept(listener: TcpListener, router: Router, asked_to_stop: impl Future<Output = ()>) {
    let (stop, stopping) = watch::channel(false);
    let connections = Arc::new(Semaphore::new(CONNECTIONS));
    let mut asked_to_stop = pin!(asked_to_stop);
    loop {
        let client = tokio::select! {
            client = next_client(&listener, &connections) => client,
            () = &mut asked_to_stop => break,
        };
        let Ok((stream, permit)) = client.inspect_err(|error| tracing::warn!("accept: {error}"))
        else {
            // Usually too many open files: wait until some are closed.
            tokio::time::sleep(Duration::from_millis(50)).await;
            continue;
        };
        let (router, stopping) = (router.clone(), stopping.clone());
        tokio::spawn(async move {
            if let Err(error) = converse(stream, router, stopping).await {
                tracing::debug!("connection: {error}");
            }
            drop(permit);
        });
    }
    drop((listener, stopping));
    tracing::info!("stopping");
    stop.send_replace(true);
    // Closed when the last connection has let go of its receiver.
    if tokio::time::timeout(STOP_TIME, stop.closed()).await.is_err() {
        tracing::warn!("requests were cut off");
    }
}

/// A client, once there is room for one more.
async fn next_client(
    listener: &TcpListener,
    connections: &Arc<Semaphore>,
) -> io::Result<(TcpStream, OwnedSemaphorePermit)> {
    let permit = Arc::clone(connections).acquire_owned().await.map_err(io::Error::other)?;
    let (stream, _) = listener.accept().await?;
    Ok((stream, permit))
}

async fn converse(
    stream: TcpStream,
    router: Router,
    mut stopping: watch::Receiver<bool>,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let mut socket = Socket::new(stream);
    {
        let mut http = http1::Builder::new();
        http.timer(TokioTimer::new()).header_read_timeout(HEAD_TIME);
        let service = TowerToHyperService::new(router);
        let mut connection = pin!(http.serve_connection(TokioIo::new(&mut socket), service));
        let ended = tokio::select! {
            ended = connection.as_mut() => ended,
            () = wait_for_stop(&mut stopping) => {
                connection.as_mut().graceful_shutdown();
                connection.as_mut().await
            }
        };
        if let Err(error) = ended {
            tracing::debug!("connection: {error}");
        }
    }
    socket.finish().await
}

/// Also when the sender is gone: then nobody else will say so.
async fn wait_for_stop(stopping: &mut watch::Receiver<bool>) {
    let _ = stopping.wait_for(|stopping| *stopping).await;
}

/// Ends when the process is asked to stop; it listens from the call on.
#[cfg(unix)]
fn stop_signal() -> io::Result<impl Future<Output = ()>> {
    use tokio::signal::unix::{SignalKind, signal};
    let (mut terminate, mut interrupt) =
        (signal(SignalKind::terminate())?, signal(SignalKind::interrupt())?);
    Ok(async move {
        tokio::select! {
            _ = terminate.recv() => {}
            _ = interrupt.recv() => {}
        }
    })
}

#[cfg(not(unix))]
fn stop_signal() -> io::Result<impl Future<Output = ()>> {
    Ok(async { tokio::signal::ctrl_c().await.unwrap_or_default() })
}
