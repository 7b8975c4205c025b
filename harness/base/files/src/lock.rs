//! Locks that survive a panic.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locks a mutex, also after a panic of a thread that held it. The caller changes the value in one step at the end, so that a panic
/// leaves the old or the new value.
pub fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_survives_a_panic() {
        let value = Mutex::new(7);
        let panicked = std::thread::scope(|scope| {
            let holder = || {
                let _held = lock(&value);
                panic!("on purpose");
            };
            scope.spawn(holder).join().is_err()
        });
        assert!(panicked && value.is_poisoned());
        assert_eq!(*lock(&value), 7);
    }
}
