//! Work shared among threads.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What `work` makes of each chunk of `size` items (≥ 1), in their order, with so many `threads` at
/// work.
///
/// A thread that is done with a chunk takes the next, so that none waits for one whose chunks are
/// harder.
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
    let next = AtomicUsize::new(0);
    let take = || {
        let mut done = Vec::new();
        while let index = next.fetch_add(1, Ordering::Relaxed)
            && let Some(chunk) = chunks.get(index)
        {
            done.push((index, work(chunk)));
        }
        done
    };
    let mut done = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads.min(chunks.len()))
            .map(|_| scope.spawn(take))
            .collect();
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
    use super::in_chunks;

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
    }

    #[test]
    #[should_panic(expected = "chunk 3")]
    fn a_panic_comes_through() {
        in_chunks(&[0, 1, 2, 3, 4], 1, 2, |chunk| {
            assert!(chunk[0] != 3, "chunk {}", chunk[0]);
        });
    }
}
