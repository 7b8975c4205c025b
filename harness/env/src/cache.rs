//! What is kept to be used again.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Mutex, PoisonError};

/// The latest things that were made, by their names, up to a number of them. Several threads may use it.
pub(crate) struct Cache<T> {
    most: usize,
    kept: Mutex<Kept<T>>,
}

struct Kept<T> {
    things: BTreeMap<String, T>,
    /// The names in the order in which they were put there.
    order: VecDeque<String>,
}

impl<T: Clone> Cache<T> {
    pub(crate) fn new(most: usize) -> Self {
        Self { most: most.max(1), kept: Mutex::new(Kept { things: BTreeMap::new(), order: VecDeque::new() }) }
    }

    /// The thing of this name: the one that is kept, or one that is made now. Two threads that lack the same one may both make
    /// it; what is made is the same.
    pub(crate) fn get<E>(&self, name: &str, make: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        // A poisoned lock holds whole things.
        let lock = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = lock().things.get(name) {
            return Ok(found.clone());
        }
        let made = make()?;
        let mut kept = lock();
        if kept.things.insert(name.to_owned(), made.clone()).is_none() {
            kept.order.push_back(name.to_owned());
        }
        while kept.order.len() > self.most {
            if let Some(oldest) = kept.order.pop_front() {
                kept.things.remove(&oldest);
            }
        }
        Ok(made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_goes_when_there_are_too_many_and_failures_are_not_kept() {
        let cache = Cache::new(2);
        let get = |name: &str, value: u32| cache.get(name, || Ok::<_, ()>(value)).unwrap();
        assert_eq!((get("a", 1), get("b", 2), get("a", 9)), (1, 2, 1));
        assert_eq!((get("c", 3), get("b", 9), get("a", 7)), (3, 2, 7));
        assert_eq!(cache.get("d", || Err::<u32, _>("no")), Err("no"));
        assert_eq!(get("d", 5), 5);
    }
}
