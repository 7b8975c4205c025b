//! Work on the frames of a video by several threads, with its results in the order of the frames.

use crate::film::FilmError;

/// Makes something of each moment by several threads, and hands it over in the order of the moments. No more than two of each
/// thread are held.
pub(crate) fn in_order<T: Send>(
    times: &[f64],
    threads: usize,
    told: &mut dyn FnMut(usize),
    make: impl Fn(usize, f64) -> Result<T, FilmError> + Sync,
    mut take: impl FnMut(T) -> Result<(), FilmError>,
) -> Result<(), FilmError> {
    let threads = threads.max(1);
    let batch = 2 * threads;
    for (b, times) in times.chunks(batch).enumerate() {
        let share = times.len().div_ceil(threads);
        let make = &make;
        let made: Vec<Result<T, FilmError>> = std::thread::scope(|scope| {
            let started: Vec<_> = times
                .chunks(share)
                .enumerate()
                .map(|(c, part)| {
                    let first = b * batch + c * share;
                    scope.spawn(move || -> Vec<_> {
                        part.iter().enumerate().map(|(k, time)| make(first + k, *time)).collect()
                    })
                })
                .collect();
            let join = |thread: std::thread::ScopedJoinHandle<'_, Vec<_>>| {
                thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            };
            started.into_iter().flat_map(join).collect()
        });
        for (k, item) in made.into_iter().enumerate() {
            take(item?)?;
            told(b * batch + k + 1);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_in_order_whatever_the_number_of_threads() {
        let times: Vec<f64> = (0..23).map(f64::from).collect();
        for threads in [1, 2, 3, 8] {
            let (mut taken, mut told) = (Vec::new(), Vec::new());
            let make = |k: usize, t: f64| Ok((k, t));
            in_order(&times, threads, &mut |n| told.push(n), make, |pair| {
                taken.push(pair);
                Ok(())
            })
            .unwrap();
            let wanted: Vec<(usize, f64)> = times.iter().copied().enumerate().collect();
            assert_eq!(taken, wanted, "{threads} threads");
            assert_eq!(told, (1..=23).collect::<Vec<usize>>());
        }
    }
}
