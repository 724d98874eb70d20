//! What the server has only so much of, be it places or bytes, and who holds it.

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use std::collections::HashMap;
use std::convert::Infallible;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Who asks, told apart by address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Client(IpAddr);

/// The part of an IPv6 address that a network is given; the rest is each host's own to choose, as
/// often as it likes.
const NETWORK: u128 = !0 << 64;

impl From<IpAddr> for Client {
    fn from(address: IpAddr) -> Self {
        Self(match address.to_canonical() {
            IpAddr::V6(v6) => Ipv6Addr::from_bits(v6.to_bits() & NETWORK).into(),
            v4 => v4,
        })
    }
}

impl Default for Client {
    fn default() -> Self {
        Self(Ipv4Addr::UNSPECIFIED.into())
    }
}

impl<S: Sync> FromRequestParts<S> for Client {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _state: &S) -> Result<Self, Infallible> {
        Ok(parts.extensions.get().copied().unwrap_or_default())
    }
}

/// So many units for all clients together, of which one client may hold a share.
#[derive(Clone, Debug)]
pub struct Budget {
    share: usize,
    accounts: Arc<Mutex<Accounts>>,
}

#[derive(Debug)]
struct Accounts {
    free: usize,
    held: HashMap<Client, usize>,
}

/// Units that a client holds; given back when this is dropped.
#[derive(Debug)]
pub struct Held {
    budget: Budget,
    client: Client,
    units: usize,
}

/// There is not so much left, or the client has its share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exhausted;

impl Budget {
    /// `all` units, of which one client may hold `share`.
    pub fn new(all: usize, share: usize) -> Self {
        let accounts = Accounts { free: all, held: HashMap::new() };
        Self { share, accounts: Arc::new(Mutex::new(accounts)) }
    }

    /// Takes units for a client.
    ///
    /// # Errors
    /// [`Exhausted`].
    pub fn take(&self, client: Client, units: usize) -> Result<Held, Exhausted> {
        let mut held = Held { budget: self.clone(), client, units: 0 };
        held.take(units)?;
        Ok(held)
    }

    fn accounts(&self) -> MutexGuard<'_, Accounts> {
        // Nothing panics under the lock, so the accounts are in order.
        self.accounts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Held {
    /// Takes more.
    ///
    /// # Errors
    /// [`Exhausted`]; what was held is still held.
    pub fn take(&mut self, units: usize) -> Result<(), Exhausted> {
        let mut accounts = self.budget.accounts();
        let own = accounts.held.get(&self.client).copied().unwrap_or_default();
        if units > accounts.free || units > self.budget.share.saturating_sub(own) {
            return Err(Exhausted);
        }
        if units > 0 {
            accounts.free -= units;
            accounts.held.insert(self.client, own + units);
        }
        drop(accounts);
        self.units += units;
        Ok(())
    }

    /// Gives back all but `units`.
    pub fn keep(&mut self, units: usize) {
        let surplus = self.units.saturating_sub(units);
        if surplus == 0 {
            return;
        }
        let mut accounts = self.budget.accounts();
        accounts.free += surplus;
        if let Some(own) = accounts.held.get_mut(&self.client) {
            *own -= surplus;
            if *own == 0 {
                accounts.held.remove(&self.client);
            }
        }
        drop(accounts);
        self.units -= surplus;
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.keep(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn client(address: &str) -> Client {
        address.parse::<IpAddr>().unwrap().into()
    }

    #[test]
    fn one_client_gets_its_share_and_leaves_the_rest_to_others() {
        let budget = Budget::new(4, 3);
        let (one, other) = (client("10.0.0.1"), client("10.0.0.2"));
        let held = budget.take(one, 3).unwrap();
        assert_eq!(budget.take(one, 1).err(), Some(Exhausted));
        let last = budget.take(other, 1).unwrap();
        assert_eq!(budget.take(other, 1).err(), Some(Exhausted));
        drop((held, last));
        assert!(budget.take(one, 3).is_ok());
        assert!(budget.accounts().held.is_empty());
    }

    #[test]
    fn what_is_held_can_grow_and_shrink() {
        let budget = Budget::new(10, 10);
        let mut held = budget.take(Client::default(), 2).unwrap();
        held.take(8).unwrap();
        assert_eq!(held.take(1), Err(Exhausted));
        held.keep(5);
        held.keep(7);
        assert_eq!(budget.accounts().free, 5);
        drop(held);
        assert_eq!(budget.accounts().free, 10);
    }

    #[test]
    fn a_client_is_an_address_or_a_network_of_addresses() {
        assert_ne!(client("10.0.0.1"), client("10.0.0.2"));
        assert_eq!(client("10.0.0.1"), client("::ffff:10.0.0.1"));
        assert_eq!(client("2001:db8::1"), client("2001:db8::2:3:4"));
        assert_ne!(client("2001:db8::1"), client("2001:db8:0:1::1"));
    }
}
