//! Work by many threads whose results are taken in order.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::{Condvar, Mutex, PoisonError};

use vb_files::lock;

/// How far the makers may be ahead of the taker: so many results for each of them.
const AHEAD: usize = 4;

struct Shared<T> {
    /// The next index to be made.
    next: usize,
    /// The next index to be taken.
    wanted: usize,
    made: BTreeMap<usize, T>,
    /// Nothing more is to be made.
    stop: bool,
    /// Makers at work.
    makers: usize,
}

/// Makes the results for `first`, `first + 1`, … on `jobs` threads and hands them to `take` in order, on this thread, until
/// `make` returns `None` for an index or `take` breaks. Only a few results wait at any time. What is taken doesn't
/// depend on the number of threads.
pub(crate) fn ordered<T: Send>(
    jobs: usize,
    stack_bytes: usize,
    first: usize,
    make: impl Fn(usize) -> Option<T> + Sync,
    mut take: impl FnMut(usize, T) -> ControlFlow<()>,
) -> std::io::Result<()> {
    let jobs = jobs.max(1);
    let shared =
        Mutex::new(Shared { next: first, wanted: first, made: BTreeMap::new(), stop: false, makers: 0 });
    let changed = Condvar::new();
    let work = || {
        loop {
            let mut state = lock(&shared);
            while !state.stop && state.next >= state.wanted + AHEAD * jobs {
                state = changed.wait(state).unwrap_or_else(PoisonError::into_inner);
            }
            if state.stop {
                return;
            }
            let index = state.next;
            state.next += 1;
            drop(state);
            let result = make(index);
            let mut state = lock(&shared);
            match result {
                Some(result) => {
                    state.made.insert(index, result);
                }
                None => state.stop = true,
            }
            changed.notify_all();
        }
    };
    /// Says that a maker is gone, however it went.
    struct Gone<'a, T>(&'a Mutex<Shared<T>>, &'a Condvar);
    impl<T> Drop for Gone<'_, T> {
        fn drop(&mut self) {
            lock(self.0).makers -= 1;
            self.1.notify_all();
        }
    }
    std::thread::scope(|scope| {
        let mut spawned = Ok(());
        for _ in 0..jobs {
            lock(&shared).makers += 1;
            let body = || {
                let _gone = Gone(&shared, &changed);
                work();
            };
            let thread = std::thread::Builder::new().stack_size(stack_bytes).spawn_scoped(scope, body);
            if let Err(e) = thread {
                let mut state = lock(&shared);
                state.makers -= 1;
                state.stop = true;
                spawned = Err(e);
                break;
            }
        }
        loop {
            let mut state = lock(&shared);
            let index = state.wanted;
            if let Some(result) = state.made.remove(&index) {
                state.wanted += 1;
                drop(state);
                changed.notify_all();
                if take(index, result).is_break() {
                    lock(&shared).stop = true;
                    changed.notify_all();
                    break;
                }
            } else if state.makers == 0 {
                break;
            } else {
                drop(changed.wait(state).unwrap_or_else(PoisonError::into_inner));
            }
        }
        spawned
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(jobs: usize, first: usize, end: usize, breaks_at: usize) -> Vec<usize> {
        let mut all = Vec::new();
        let make = |k: usize| {
            // The odd ones take longer.
            std::thread::yield_now();
            (k < end).then(|| if k % 2 == 1 { (0..2000).fold(k, |a, _| std::hint::black_box(a)) } else { k })
        };
        ordered(jobs, 1 << 20, first, make, |k, result| {
            assert_eq!(k, result);
            all.push(k);
            if k == breaks_at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .unwrap();
        all
    }

    #[test]
    fn results_come_in_order_whatever_the_number_of_threads() {
        for jobs in [1, 2, 7] {
            assert_eq!(taken(jobs, 0, 100, usize::MAX), (0..100).collect::<Vec<_>>());
            assert_eq!(taken(jobs, 40, 100, 60), (40..=60).collect::<Vec<_>>());
            assert_eq!(taken(jobs, 0, 0, usize::MAX), Vec::<usize>::new());
        }
    }

    #[test]
    fn makers_don_t_run_away() {
        let ahead = std::sync::atomic::AtomicUsize::new(0);
        let make = |k: usize| {
            ahead.fetch_max(k, std::sync::atomic::Ordering::Relaxed);
            Some(k)
        };
        ordered(2, 1 << 20, 0, make, |k, _| {
            // While the first is taken, the makers stop before the eighth of those after it.
            std::thread::sleep(std::time::Duration::from_millis(20));
            assert!(ahead.load(std::sync::atomic::Ordering::Relaxed) <= k + 1 + 2 * AHEAD);
            if k == 5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .unwrap();
    }

    #[test]
    fn a_maker_s_panic_ends_it_all() {
        let panics = std::panic::catch_unwind(|| {
            let make = |k: usize| if k == 3 { panic!("three") } else { Some(k) };
            ordered(1, 1 << 20, 0, make, |_, _| ControlFlow::Continue(()))
        });
        assert!(panics.is_err());
    }
}
