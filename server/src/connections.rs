//! Who is connected: so many clients at a time, and beside them always somebody who only watches.

use crate::app::{App, Phase};
use crate::budget::{Budget, Client, Held};
use crate::layers::Spare;
use crate::routes;
use crate::seat::Seat;
use crate::socket::Socket;
use axum::Router;
use axum::extract::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, watch};
use tokio::task::AbortHandle;
use tokio::time::Instant;

/// How long a client may take to send the head of a request, and stay connected without one.
const HEAD_TIME: Duration = Duration::from_secs(10);

/// The same on a spare connection: whoever watches asks at once.
const SPARE_HEAD_TIME: Duration = Duration::from_secs(2);

/// Connections at a time; a process may have 1024 open files where nobody says otherwise.
const CONNECTIONS: usize = 512;

/// The part of them that one client may have: browsers open six, test suites a few dozen.
const CLIENT_CONNECTIONS: usize = 256;

/// Connections beyond these, on which health is told and everything else refused. When there are
/// more, the oldest has to go.
const SPARE_CONNECTIONS: usize = 256;

/// What a spare connection may have at least: health is told within a millisecond, but on a busy
/// machine it takes a while to be the server's turn. Silent clients are accepted no faster than this
/// allows.
const SPARE_TIME: Duration = Duration::from_millis(250);

/// Accepts clients and converses with them.
pub struct Connections {
    router: Router,
    phase: watch::Receiver<Phase>,
    places: Budget,
    /// From when on each may be closed, the oldest first.
    spare: VecDeque<(Instant, AbortHandle)>,
    /// Every conversation holds a copy of the first; the second hears when there are none.
    alive: Option<mpsc::Sender<()>>,
    all_ended: mpsc::Receiver<()>,
}

/// What a connection may be used for.
enum Place {
    /// Everything, while this is held.
    Own(#[expect(dead_code, reason = "it counts until it is dropped")] Held),
    /// Asking how the process is.
    Spare,
}

impl Connections {
    /// Nobody is connected yet.
    pub fn new(app: App) -> Self {
        let (alive, all_ended) = mpsc::channel(1);
        Self {
            phase: app.phase.clone(),
            router: routes::router(app),
            places: Budget::new(CONNECTIONS, CLIENT_CONNECTIONS),
            spare: VecDeque::new(),
            alive: Some(alive),
            all_ended,
        }
    }

    /// Accepts clients until it is dropped.
    pub async fn accept(&mut self, listener: TcpListener) {
        loop {
            match listener.accept().await {
                Ok((stream, address)) => self.begin(stream, address).await,
                Err(error) => {
                    tracing::warn!("accept: {error}");
                    // Usually too many open files: wait until some are closed.
                    tokio::time::sleep(Duration::from_millis(50)).await;
                }
            }
        }
    }

    async fn begin(&mut self, stream: TcpStream, address: SocketAddr) {
        let client = Client::from(address.ip());
        let place = self.places.take(client, 1).map_or(Place::Spare, Place::Own);
        let is_spare = matches!(place, Place::Spare);
        let (router, phase) = (self.router.clone(), self.phase.clone());
        let seat = Seat::holding((place, self.alive.clone()));
        let conversation = tokio::spawn(async move {
            if let Err(error) = converse(stream, (client, is_spare), seat, router, phase).await {
                tracing::debug!("connection: {error}");
            }
        });
        if !is_spare {
            return;
        }
        self.spare.push_back((Instant::now() + SPARE_TIME, conversation.abort_handle()));
        if self.spare.len() > SPARE_CONNECTIONS
            && let Some((end, oldest)) = self.spare.pop_front()
            && !oldest.is_finished()
        {
            tokio::time::sleep_until(end).await;
            oldest.abort();
        }
    }

    /// Waits until all conversations have ended; there will be no others.
    pub async fn ended(&mut self) {
        self.alive = None;
        // Nothing is ever sent.
        let _ = self.all_ended.recv().await;
    }
}

async fn converse(
    stream: TcpStream,
    (client, is_spare): (Client, bool),
    seat: Seat,
    router: Router,
    phase: watch::Receiver<Phase>,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let router = TowerToHyperService::new(router);
    let service = service_fn(move |mut request: Request<Incoming>| {
        request.extensions_mut().insert(client);
        request.extensions_mut().insert(seat.clone());
        if is_spare {
            request.extensions_mut().insert(Spare);
        }
        router.call(request)
    });
    let mut http = http1::Builder::new();
    let head_time = if is_spare { SPARE_HEAD_TIME } else { HEAD_TIME };
    http.timer(TokioTimer::new()).header_read_timeout(head_time).keep_alive(!is_spare);
    let socket = TokioIo::new(Socket::new(stream));
    let mut connection = http.serve_connection(socket, service).with_upgrades();
    let ended = tokio::select! {
        ended = &mut connection => Some(ended),
        () = Phase::Draining.begun(phase) => None,
    };
    let ended = match ended {
        Some(ended) => ended,
        None => {
            Pin::new(&mut connection).graceful_shutdown();
            (&mut connection).await
        }
    };
    if let Err(error) = ended {
        tracing::debug!("connection: {error}");
    }
    match connection.into_parts() {
        // Nobody is waited for on a spare one: the next one may want to know how the process is.
        Some(parts) if !is_spare => parts.io.into_inner().finish().await,
        // Whoever took it over goes on with it.
        _ => Ok(()),
    }
}
