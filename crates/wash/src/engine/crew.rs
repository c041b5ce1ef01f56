//! Threads that stay awake between the passes of a run.
//!
//! A pass over a small canvas takes half a millisecond, and some hundredths of one lie between it and the next. A thread
//! that falls asleep in between, or while the last band is still at work, has to be woken, which takes up to a tenth of a step.

use std::hint::spin_loop;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// How long a thread stays awake without work.
const PATIENCE: Duration = Duration::from_micros(200);

/// The threads that share the bands of a pool of water.
#[derive(Debug, Default)]
pub struct Crew {
    /// Passes begun.
    begun: Arc<AtomicUsize>,
}

impl Crew {
    /// Does all works on as many threads, the first one on this; the results are in the order of the works.
    ///
    /// The other threads then stay awake a little for the next call.
    pub fn share<W: Send, R: Send>(&self, works: Vec<W>, work: impl Fn(W) -> R + Sync) -> Vec<R> {
        let mut works = works.into_iter();
        let helpers = works.len().saturating_sub(1);
        if helpers == 0 {
            return works.map(work).collect();
        }
        let pass = self.begun.fetch_add(1, Ordering::Release) + 1;
        let mut results: Vec<Option<R>> = works.as_slice().iter().map(|_| None).collect();
        let [to_begin, to_end] = [(); 2].map(|()| AtomicUsize::new(helpers));
        let is_own_done = AtomicBool::new(false);
        rayon::scope(|scope| {
            let mut slots = results.iter_mut();
            let own = slots.next().zip(works.next());
            let (to_begin, to_end, is_own_done, work) = (&to_begin, &to_end, &is_own_done, &work);
            for (slot, item) in slots.zip(works) {
                scope.spawn(move |_| {
                    to_begin.fetch_sub(1, Ordering::Relaxed);
                    *slot = Some(work(item));
                    to_end.fetch_sub(1, Ordering::Release);
                    // Lest it fall asleep before it is asked to wait for the next pass.
                    stay_awake(|| is_own_done.load(Ordering::Acquire), spin_loop);
                });
            }
            if let Some((slot, item)) = own {
                *slot = Some(work(item));
            }
            (0..helpers).for_each(|_| self.ask_to_wait(pass));
            is_own_done.store(true, Ordering::Release);
            let meanwhile = || match to_begin.load(Ordering::Relaxed) {
                0 => spin_loop(),
                _ => do_other_work(),
            };
            stay_awake(|| to_end.load(Ordering::Acquire) == 0, meanwhile);
        });
        results.into_iter().flatten().collect()
    }

    /// Asks another thread to stay awake until the pass after this one begins.
    fn ask_to_wait(&self, pass: usize) {
        let (begun, this) = (Arc::clone(&self.begun), rayon::current_thread_index());
        rayon::spawn(move || {
            // This thread has to begin that pass.
            if rayon::current_thread_index() != this {
                stay_awake(|| begun.load(Ordering::Acquire) != pass, do_other_work);
            }
        });
    }
}

fn do_other_work() {
    if rayon::yield_now() != Some(rayon::Yield::Executed) {
        spin_loop();
    }
}

/// Goes on with something until it is so, or for as long as patience lasts.
fn stay_awake(is_so: impl Fn() -> bool, meanwhile: impl Fn()) {
    let start = Instant::now();
    while !is_so() && start.elapsed() < PATIENCE {
        meanwhile();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shares works of all sizes, from two threads of a pool at once.
    fn share_in_pool(threads: usize) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let run = || {
            let crew = Crew::default();
            for pass in 0..300usize {
                let works: Vec<usize> = (0..pass % 6).collect();
                let squares: Vec<usize> = works.iter().map(|work| work * work).collect();
                assert_eq!(crew.share(works, |work| work * work), squares);
            }
        };
        pool.join(run, run);
    }

    #[test]
    fn results_are_in_order_for_any_number_of_threads() {
        for threads in [1, 2, 3, 7] {
            share_in_pool(threads);
        }
    }

    #[test]
    fn a_panic_in_a_band_is_not_waited_for_forever() {
        for bad in 0..3 {
            let crew = Crew::default();
            let work = |work: usize| assert_ne!(work, bad, "this band panics");
            let shared =
                std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| crew.share(vec![0, 1, 2], work)));
            assert!(shared.is_err(), "{bad}");
        }
    }
}
