//! Work shared among threads. Results come in the order of the work, whatever the number of
//! threads.

use std::cell::Cell;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Threads that the machine runs at once, at least 1.
pub fn available() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

thread_local! {
    /// Whether this thread has a share of work.
    static IS_SHARING: Cell<bool> = const { Cell::new(false) };
}

/// Whether the work of this thread is a share of more, which has the processors already.
pub fn is_shared() -> bool {
    IS_SHARING.get()
}

/// `work` of 0 to `count` − 1, on all processors.
///
/// # Panics
/// As `work` does.
pub fn map<R: Send>(count: usize, work: impl Fn(usize) -> R + Sync) -> Vec<R> {
    map_on(available(), count, work)
}

/// `work` of each chunk of `size` items (≥ 1), on so many `threads`.
///
/// # Panics
/// If `size` is 0, and as `work` does.
pub fn in_chunks<T: Sync, R: Send>(
    items: &[T],
    size: usize,
    threads: usize,
    work: impl Fn(&[T]) -> R + Sync,
) -> Vec<R> {
    let chunks: Vec<&[T]> = items.chunks(size).collect();
    map_on(threads, chunks.len(), |k| work(chunks[k]))
}

/// `work` of 0 to `count` − 1, on so many `threads`. A thread that is done with one takes the next,
/// so that no thread waits for another with harder work.
///
/// # Panics
/// As `work` does.
pub fn map_on<R: Send>(threads: usize, count: usize, work: impl Fn(usize) -> R + Sync) -> Vec<R> {
    if threads.min(count) <= 1 {
        return (0..count).map(work).collect();
    }
    let next = AtomicUsize::new(0);
    let take = || {
        let before = IS_SHARING.replace(true);
        let mut done = Vec::new();
        while let index = next.fetch_add(1, Ordering::Relaxed)
            && index < count
        {
            done.push((index, work(index)));
        }
        IS_SHARING.set(before);
        done
    };
    let mut done = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads.min(count)).map(|_| scope.spawn(take)).collect();
        let mut done = take();
        for other in others {
            done.extend(other.join().unwrap_or_else(|panic| resume_unwind(panic)));
        }
        done
    });
    done.sort_unstable_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_chunk_is_worked_on_once_and_in_order() {
        let items: Vec<usize> = (0..101).collect();
        for threads in [1, 2, 7, 200] {
            for size in [1, 4, 100, 101, 500] {
                let parts = in_chunks(&items, size, threads, <[usize]>::to_vec);
                assert_eq!(parts.len(), items.len().div_ceil(size));
                assert_eq!(
                    parts.concat(),
                    items,
                    "chunks of {size} by {threads} threads"
                );
            }
        }
        assert!(in_chunks(&[0; 0], 4, 2, <[i32]>::len).is_empty());
        assert_eq!(map(5, |k| k * k), [0, 1, 4, 9, 16]);
    }

    #[test]
    #[should_panic(expected = "chunk 3")]
    fn a_panic_comes_through() {
        in_chunks(&[0, 1, 2, 3, 4], 1, 2, |chunk| {
            assert!(chunk[0] != 3, "chunk {}", chunk[0]);
        });
    }
}
