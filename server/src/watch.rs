//! Jobs that a client may ask about while they wait and run, by an id of the client's choice.

use crate::problem::Problem;
use axum::http::{HeaderMap, StatusCode};
use fogbank_core::Progress;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The header that names a job.
pub const HEADER: &str = "Fog-Job";

/// Characters of an id.
const ID_CHARS: usize = 64;

/// What an id looks like.
pub const ID_PATTERN: &str = "^[A-Za-z0-9_-]{1,64}$";

/// More than the queue ever holds; a bound all the same.
const JOBS: usize = 4096;

/// What a client calls its job.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct JobId(String);

impl JobId {
    /// The id that a request gives its job, if any.
    ///
    /// # Errors
    /// 400 where it is none.
    pub fn of(headers: &HeaderMap) -> Result<Option<Self>, Problem> {
        let Some(value) = headers.get(HEADER) else { return Ok(None) };
        let id = value.to_str().ok().and_then(Self::read);
        let detail = format!("{HEADER} must be 1 to {ID_CHARS} of A–Z, a–z, 0–9, - and _");
        id.map(Some).ok_or_else(|| Problem::new(StatusCode::BAD_REQUEST, detail))
    }

    /// An id, if this is one.
    pub fn read(text: &str) -> Option<Self> {
        let is_short = (1..=ID_CHARS).contains(&text.len());
        let is_plain = text.bytes().all(|c| c.is_ascii_alphanumeric() || b"-_".contains(&c));
        (is_short && is_plain).then(|| Self(text.into()))
    }
}

/// The jobs that wait or run and have an id.
#[derive(Clone, Default)]
pub struct Watch(Arc<Mutex<HashMap<JobId, Arc<Progress>>>>);

/// Forgets a job when it is dropped.
pub struct Watched {
    watch: Watch,
    id: JobId,
}

impl Watch {
    /// Lets clients ask for a job's progress until the answer is dropped.
    ///
    /// # Errors
    /// 409 when another job has that id, 503 when there are too many.
    pub fn add(&self, id: JobId, progress: &Arc<Progress>) -> Result<Watched, Problem> {
        let mut jobs = self.jobs();
        if jobs.len() >= JOBS {
            return Err(Problem::busy("too many jobs are watched"));
        }
        match jobs.entry(id.clone()) {
            Entry::Occupied(_) => {
                let detail = format!("another job has this {HEADER}");
                return Err(Problem::new(StatusCode::CONFLICT, detail));
            }
            Entry::Vacant(place) => place.insert(Arc::clone(progress)),
        };
        drop(jobs);
        Ok(Watched { watch: self.clone(), id })
    }

    /// The progress of the job with that id.
    pub fn get(&self, id: &JobId) -> Option<Arc<Progress>> {
        self.jobs().get(id).cloned()
    }

    fn jobs(&self) -> MutexGuard<'_, HashMap<JobId, Arc<Progress>>> {
        // Nothing is left half done under the lock.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        self.watch.jobs().remove(&self.id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documented_pattern_has_the_same_bound() {
        assert!(ID_PATTERN.ends_with(&format!("{{1,{ID_CHARS}}}$")));
    }

    #[test]
    fn an_id_is_short_and_plain() {
        assert_eq!(JobId::read("a-Z_9"), Some(JobId("a-Z_9".into())));
        let long = "a".repeat(ID_CHARS + 1);
        for text in ["", "a b", "ä", "a/b", long.as_str()] {
            assert_eq!(JobId::read(text), None, "{text}");
        }
    }

    #[test]
    fn a_job_is_known_until_it_ends_and_no_other_takes_its_id() {
        let (watch, progress) = (Watch::default(), Arc::default());
        let id = JobId("a".into());
        let watched = watch.add(id.clone(), &progress).ok();
        assert!(watched.is_some() && watch.get(&id).is_some());
        let other = watch.add(id.clone(), &progress).map(drop);
        assert_eq!(other.map_err(|problem| problem.status()), Err(StatusCode::CONFLICT));
        assert!(watch.get(&id).is_some());
        drop(watched);
        assert!(watch.get(&id).is_none());
        assert!(watch.add(id, &progress).is_ok());
    }

    #[test]
    fn there_are_never_more_than_the_bound() {
        let (watch, progress) = (Watch::default(), Arc::default());
        let ids = (0..JOBS).map(|i| JobId(i.to_string()));
        let all: Vec<_> = ids.map(|id| watch.add(id, &progress).map_err(|_| "full")).collect();
        assert!(all.iter().all(Result::is_ok));
        let more = watch.add(JobId("more".into()), &progress).map(drop);
        assert_eq!(more.map_err(|problem| problem.status()), Err(StatusCode::SERVICE_UNAVAILABLE));
        drop(all);
        assert!(watch.add(JobId("more".into()), &progress).is_ok());
    }
}
