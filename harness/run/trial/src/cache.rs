//! Values that are kept to be used again.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex};

use vb_files::lock;

/// The latest values that were made, by name, up to a number of them. Threads share it.
#[derive(Debug)]
pub struct Cache<T> {
    most: usize,
    kept: Mutex<Kept<T>>,
}

/// A value, or that it is still to be made.
type Slot<T> = Arc<Mutex<Option<T>>>;

#[derive(Debug)]
struct Kept<T> {
    slots: BTreeMap<String, Slot<T>>,
    /// The names in the order in which they were first asked for.
    order: VecDeque<String>,
}

impl<T: Clone> Cache<T> {
    /// An empty cache of `most` values, at least 1.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self { most: most.max(1), kept: Mutex::new(Kept { slots: BTreeMap::new(), order: VecDeque::new() }) }
    }

    /// The value of this name: the one that is kept, or one that `make` makes now. Two threads do not make the same value, and make
    /// different ones at the same time. The oldest name goes when there are too many.
    ///
    /// # Errors
    /// Returns the error of `make`; nothing is kept then.
    pub fn get<E>(&self, name: &str, make: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let slot = self.slot(name);
        // Held until the value is made.
        let mut value = lock(&slot);
        if let Some(value) = &*value {
            return Ok(value.clone());
        }
        let made = make()?;
        *value = Some(made.clone());
        Ok(made)
    }

    fn slot(&self, name: &str) -> Slot<T> {
        let mut kept = lock(&self.kept);
        if let Some(slot) = kept.slots.get(name) {
            return slot.clone();
        }
        let slot = Slot::default();
        kept.slots.insert(name.to_owned(), slot.clone());
        kept.order.push_back(name.to_owned());
        while kept.order.len() > self.most {
            if let Some(oldest) = kept.order.pop_front() {
                kept.slots.remove(&oldest);
            }
        }
        slot
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn the_oldest_goes_when_there_are_too_many_and_failures_are_not_kept() {
        let cache = Cache::new(2);
        let get = |name: &str, value: u32| cache.get(name, || Ok::<_, ()>(value)).unwrap();
        assert_eq!((get("a", 1), get("b", 2), get("a", 9)), (1, 2, 1));
        assert_eq!((get("c", 3), get("b", 9), get("a", 7)), (3, 2, 7));
        assert_eq!(cache.get("d", || Err::<u32, _>("no")), Err("no"));
        assert_eq!(get("d", 5), 5);
    }

    #[test]
    fn threads_that_want_the_same_value_make_it_once() {
        let (cache, made) = (Cache::new(2), AtomicUsize::new(0));
        let make = || {
            std::thread::yield_now();
            Ok::<_, ()>(made.fetch_add(1, Ordering::Relaxed))
        };
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| assert_eq!(cache.get("a", make), Ok(0)));
            }
        });
        assert_eq!(made.into_inner(), 1);
    }
}
