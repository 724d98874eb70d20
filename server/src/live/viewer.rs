//! Who sits at a socket: the latest view wins, acknowledgements bound what is on its way, drafts come while things move and
//! a full frame when they rest.

use super::message::{Down, Tier, Up, Wanted, of_edit};
use super::picture::{Picture, Task, make};
use super::scale::Scale;
use crate::app::{App, Phase};
use crate::budget::Client;
use crate::edits::EditsRequest;
use crate::estimate::lane_of_picture;
use crate::problem::Problem;
use crate::queue::Lane;
use crate::store::record::Head;
use crate::store::{Condition, Refusal, Room};
use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use fogbank_core::Progress;
use std::collections::VecDeque;
use std::pin::Pin;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::{OwnedSemaphorePermit, mpsc};
use tokio::time::{MissedTickBehavior, interval, sleep_until};

/// Frames that a client has not acknowledged: one that it shows, and one on its way to it.
const UNACKNOWLEDGED: usize = 2;

/// Nothing moves any more when nothing has come for so long.
const REST: Duration = Duration::from_millis(120);

/// How often a client is asked whether it is there, and how long it may be silent.
const HEARTBEAT: Duration = Duration::from_secs(15);
const SILENCE: Duration = Duration::from_secs(45);

/// Edits of one client that wait to be made.
const EDITS: usize = 16;

/// How long a client may take to say good-bye.
const GOOD_BYE: Duration = Duration::from_secs(1);

/// The scene is gone: a code of this program.
const GONE: u16 = 4404;

/// Why a conversation ends.
type End = (u16, &'static str);

/// What a viewer waits for.
enum Waiting {
    /// A turn of the renderer.
    Turn(Pin<Box<dyn Future<Output = Option<OwnedSemaphorePermit>> + Send>>, Instant),
    /// A frame of that tier.
    Frame(Pin<Box<dyn Future<Output = Result<Picture, Problem>> + Send>>, Tier),
}

/// Somebody who looks at a scene.
pub struct Viewer {
    socket: WebSocket,
    app: App,
    room: Arc<Room>,
    client: Client,
    /// What the client knows of the scene.
    told: Arc<Head>,
    /// The revision that it said that it has.
    known: Option<u64>,
    /// What it wants to see.
    wanted: Option<Wanted>,
    /// Whether something has changed since the last draft was begun.
    has_moved: bool,
    /// When things rest, if a full frame is due then.
    rest: Option<Instant>,
    waiting: Option<Waiting>,
    frames: u64,
    unacknowledged: VecDeque<u64>,
    scale: Scale,
}

impl Viewer {
    /// Somebody new.
    pub fn new(
        socket: WebSocket,
        app: App,
        room: Arc<Room>,
        (head, known): (Arc<Head>, Option<u64>),
        client: Client,
    ) -> Self {
        Self {
            socket,
            app,
            room,
            client,
            told: head,
            known,
            wanted: None,
            has_moved: false,
            rest: None,
            waiting: None,
            frames: 0,
            unacknowledged: VecDeque::new(),
            scale: Scale::default(),
        }
    }

    /// Converses until one of both goes.
    pub async fn serve(mut self) {
        self.room.viewers.send_modify(|count| *count += 1);
        let end = self.converse().await;
        self.room.viewers.send_modify(|count| *count -= 1);
        self.waiting = None;
        if let Some((code, reason)) = end {
            let close = Message::Close(Some(CloseFrame { code, reason: reason.into() }));
            let good_bye = async {
                if self.socket.send(close).await.is_ok() {
                    while let Some(Ok(_)) = self.socket.recv().await {}
                }
            };
            // Whoever does not answer has been told all the same.
            let _ = tokio::time::timeout(GOOD_BYE, good_bye).await;
        }
    }

    /// Why the server ends the conversation; none if the client did.
    async fn converse(&mut self) -> Option<End> {
        let told = Arc::clone(&self.told);
        let is_known = self.known == Some(told.revision);
        self.greet(&told, is_known).await?;
        let mut heads = self.room.shown.subscribe();
        let mut viewers = self.room.viewers.subscribe();
        viewers.mark_changed();
        heads.mark_changed();
        let (refused, mut refusals) = mpsc::channel(EDITS);
        let edits = self.edits(refused);
        let mut beat = interval(HEARTBEAT);
        beat.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut heard = Instant::now();
        let mut going = std::pin::pin!(Phase::Draining.begun(self.app.phase.clone()));
        loop {
            self.begin();
            // While a draft is made the scene that it shows is the newest that the client hears of.
            let may_tell = !matches!(self.waiting, Some(Waiting::Frame(_, Tier::Draft)));
            let rest = self.rest.filter(|_| self.may_draw());
            tokio::select! {
                message = self.socket.recv() => {
                    heard = Instant::now();
                    match message? {
                        Ok(message) => self.hear(message, &edits).await?,
                        Err(_) => return Some((close_code::SIZE, "a message is too large, or none")),
                    }
                }
                changed = heads.changed(), if may_tell => {
                    // The room is held here: it goes on showing.
                    changed.ok()?;
                    let head = heads.borrow_and_update().clone();
                    let Some(head) = head else { return Some((GONE, "the scene was deleted")) };
                    self.tell(head).await?;
                }
                changed = viewers.changed() => {
                    changed.ok()?;
                    let count = *viewers.borrow_and_update();
                    self.say(&Down::Viewers { count }).await?;
                }
                Some((seq, problem)) = refusals.recv() => {
                    self.say(&Down::Error { seq: Some(seq), problem: &problem }).await?;
                }
                came = ready(&mut self.waiting) => self.take(came).await?,
                () = sleep_until(rest.unwrap_or(heard + SILENCE).into()), if rest.is_some() => {}
                _ = beat.tick() => {
                    if heard.elapsed() > SILENCE {
                        return Some((close_code::POLICY, "nothing was heard for too long"));
                    }
                    self.socket.send(Message::Ping(Vec::new().into())).await.ok()?;
                }
                () = &mut going => return Some((close_code::AWAY, "the server stops")),
            }
        }
    }

    /// The first word, and the one after a leap: the scene as it is.
    async fn greet(&mut self, head: &Head, is_known: bool) -> Option<()> {
        let id = self.room.id.clone();
        let scene = (!is_known).then_some(&*head.scene);
        self.say(&Down::Hello { id: &id, revision: head.revision, scene }).await
    }

    async fn say(&mut self, message: &Down<'_>) -> Option<()> {
        let text = serde_json::to_string(message).unwrap_or_default();
        self.socket.send(Message::Text(text.into())).await.ok()
    }

    async fn hear(
        &mut self,
        message: Message,
        edits: &mpsc::Sender<(u64, EditsRequest)>,
    ) -> Option<()> {
        let text = match message {
            Message::Text(text) => text,
            // A good-bye is answered when the next message is waited for, and then there is none.
            Message::Ping(_) | Message::Pong(_) | Message::Close(_) => return Some(()),
            Message::Binary(_) => {
                let problem = Problem::invalid(Vec::new());
                return self.say(&Down::Error { seq: None, problem: &problem }).await;
            }
        };
        match Up::read(&text) {
            Ok(Up::View(wanted)) => {
                self.wanted = Some(*wanted);
                self.moved();
                Some(())
            }
            Ok(Up::Stop) => {
                self.wanted = None;
                self.waiting = None;
                self.rest = None;
                Some(())
            }
            Ok(Up::Ack(frame)) => {
                self.unacknowledged.retain(|other| *other > frame);
                Some(())
            }
            Ok(Up::Edit(seq, request)) => match edits.try_send((seq, *request)) {
                Ok(()) => Some(()),
                Err(_) => {
                    let problem = Problem::busy("too many edits wait");
                    self.say(&Down::Error { seq: Some(seq), problem: &problem }).await
                }
            },
            Err((seq, problem)) => self.say(&Down::Error { seq, problem: &problem }).await,
        }
    }

    /// Something moved: a draft is due, and a full frame when it rests.
    fn moved(&mut self) {
        self.has_moved = true;
        self.rest = Some(Instant::now() + REST);
        if matches!(self.waiting, Some(Waiting::Frame(_, Tier::Full))) {
            // Nobody wants it any more, and a hand does not wait.
            self.waiting = None;
        }
    }

    /// Tells what changed since the client heard of the scene.
    async fn tell(&mut self, head: Arc<Head>) -> Option<()> {
        if head.revision < self.told.revision {
            // It is a preset again.
            self.told = Arc::clone(&head);
            self.greet(&head, false).await?;
            self.moved();
            return Some(());
        }
        if head.revision == self.told.revision {
            return Some(());
        }
        let (store, id) = (Arc::clone(&self.app.store), self.room.id.clone());
        let (from, to) = (self.told.revision, head.revision);
        let read = move || store.changes_since(&id, from, to);
        match tokio::task::spawn_blocking(read).await.ok()? {
            Ok(patch) => {
                self.told = head;
                self.say(&Down::Scene { revision: to, patch: &patch }).await?;
            }
            // History does not reach back so far: all of it, as in the beginning.
            Err(_) => {
                self.told = Arc::clone(&head);
                self.greet(&head, false).await?;
            }
        }
        self.moved();
        Some(())
    }

    /// Whether a frame may be begun, if one is due.
    fn may_draw(&self) -> bool {
        let has_shown = self.unacknowledged.len() < UNACKNOWLEDGED;
        self.waiting.is_none() && self.wanted.is_some() && has_shown
    }

    /// Asks for a turn of the renderer, if there is something to draw and the client has shown what it got.
    fn begin(&mut self) {
        let is_full_due = self.rest.is_some_and(|rest| Instant::now() >= rest);
        if !self.may_draw() || !(self.has_moved || is_full_due) {
            return;
        }
        let Some(wanted) = &self.wanted else { return };
        // Who sees a slow scene waits for others who do, and for nobody else.
        let turns = match lane_of_picture(&self.told.scene, &wanted.view) {
            Lane::Short => Arc::clone(&self.app.turns),
            Lane::Long => Arc::clone(&self.app.long_turns),
        };
        let turn = Box::pin(async move { turns.acquire_owned().await.ok() });
        self.waiting = Some(Waiting::Turn(turn, Instant::now()));
    }

    /// Goes on with what was waited for.
    async fn take(&mut self, came: Came) -> Option<()> {
        match came {
            Came::Turn(permit, since) => {
                let wanted = self.wanted.clone()?;
                // What came meanwhile is what is drawn.
                let tier = if self.has_moved { Tier::Draft } else { Tier::Full };
                self.has_moved = false;
                if tier == Tier::Full {
                    self.rest = None;
                }
                self.frames += 1;
                let head = Arc::clone(&self.told);
                let task =
                    Task { frame: self.frames, wanted, head, tier, scale: self.scale, since };
                let (app, client) = (self.app.clone(), self.client);
                let frame = Box::pin(async move {
                    let picture = make(app, client, task).await;
                    drop(permit);
                    picture
                });
                self.waiting = Some(Waiting::Frame(frame, tier));
                Some(())
            }
            Came::Frame(Ok(picture)) => {
                if picture.tier == Tier::Draft {
                    self.scale.learn(picture.took, picture.is_typical, picture.pixels);
                }
                self.unacknowledged.push_back(self.frames);
                self.socket.send(Message::Binary(picture.bytes)).await.ok()
            }
            Came::Frame(Err(problem)) if problem.status().as_u16() == 503 => {
                // Others have the renderer: it is tried again when things rest, or move.
                self.rest = Some(Instant::now() + REST);
                Some(())
            }
            Came::Frame(Err(problem)) => {
                let seq = self.wanted.as_ref().map(|wanted| wanted.seq);
                self.say(&Down::Error { seq, problem: &problem }).await
            }
        }
    }

    /// Makes this client's edits, one after the other; what is refused comes back.
    fn edits(&self, refused: mpsc::Sender<(u64, Problem)>) -> mpsc::Sender<(u64, EditsRequest)> {
        let (send, mut come) = mpsc::channel::<(u64, EditsRequest)>(EDITS);
        let (app, id) = (self.app.clone(), self.room.id.clone());
        tokio::spawn(async move {
            while let Some((seq, request)) = come.recv().await {
                let (store, renderer) = (Arc::clone(&app.store), Arc::clone(&app.renderer));
                let (id, deadline) = (id.clone(), app.deadline(false));
                let make = move || {
                    let progress = Progress::until(deadline);
                    store.write(&id, &Condition::default(), None, |head, strokes| {
                        request.make((head, strokes), &renderer, &progress)
                    })
                };
                let refused = refused.clone();
                let tell = move |refusal: Refusal| {
                    let problem = match refusal {
                        Refusal::Invalid(problems) => Problem::invalid(of_edit(problems)),
                        other => other.into(),
                    };
                    (seq, problem)
                };
                match tokio::task::spawn_blocking(make).await {
                    // The next one need not wait until this one is durable: they are made so together.
                    Ok(Ok(writing)) => {
                        tokio::spawn(async move {
                            if let Err(refusal) = writing.durable().await {
                                let _ = refused.send(tell(refusal)).await;
                            }
                        });
                    }
                    Ok(Err(refusal)) => {
                        let _ = refused.send(tell(refusal)).await;
                    }
                    Err(error) => {
                        let _ = refused.send((seq, error.into())).await;
                    }
                }
            }
        });
        send
    }
}

/// What was waited for.
enum Came {
    Turn(Option<OwnedSemaphorePermit>, Instant),
    Frame(Result<Picture, Problem>),
}

/// What is waited for, when it comes; never, if nothing is.
async fn ready(waiting: &mut Option<Waiting>) -> Came {
    let came = match waiting {
        None => std::future::pending().await,
        Some(Waiting::Turn(turn, since)) => {
            let since = *since;
            Came::Turn(turn.await, since)
        }
        Some(Waiting::Frame(frame, _)) => Came::Frame(frame.await),
    };
    *waiting = None;
    came
}
