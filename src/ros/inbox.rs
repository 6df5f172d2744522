//! What waits for the worker: commands in order, and the newest frame alone.
//!
//! Whoever puts something in never waits for the worker. A frame that arrives before the last one was taken replaces it,
//! so that slow work never makes the node fall behind.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What the worker does next.
#[derive(Debug, PartialEq, Eq)]
pub enum Next<F, C> {
    /// A command; commands go before frames.
    Command(C),
    /// The newest frame.
    Frame(F),
    /// Nothing came in time.
    Nothing,
    /// Nothing will come any more.
    Closed,
}

/// How many frames came and went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FrameCounts {
    /// Put in.
    pub received: u64,
    /// Replaced before they were taken.
    pub dropped: u64,
}

/// The worker's inbox.
#[derive(Debug)]
pub struct Inbox<F, C> {
    waiting: Mutex<Waiting<F, C>>,
    changed: Condvar,
}

#[derive(Debug)]
struct Waiting<F, C> {
    frame: Option<F>,
    commands: VecDeque<C>,
    closed: bool,
    counts: FrameCounts,
}

impl<F, C> Default for Inbox<F, C> {
    fn default() -> Self {
        Self {
            waiting: Mutex::new(Waiting {
                frame: None,
                commands: VecDeque::new(),
                closed: false,
                counts: FrameCounts::default(),
            }),
            changed: Condvar::new(),
        }
    }
}

impl<F, C> Inbox<F, C> {
    /// Puts in a frame, in place of one that still waits.
    pub fn put_frame(&self, frame: F) {
        let mut waiting = self.lock();
        waiting.counts.received += 1;
        let old = waiting.frame.replace(frame);
        waiting.counts.dropped += u64::from(old.is_some());
        drop(waiting);
        self.changed.notify_one();
    }

    /// Puts in a command, behind those that still wait.
    pub fn put_command(&self, command: C) {
        self.lock().commands.push_back(command);
        self.changed.notify_one();
    }

    /// Ends the work: whatever still waits is not handed out any more.
    pub fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_all();
    }

    /// Waits for something to do, at most as long as `limit`.
    pub fn next(&self, limit: Duration) -> Next<F, C> {
        let end = Instant::now() + limit;
        let mut waiting = self.lock();
        loop {
            if waiting.closed {
                return Next::Closed;
            }
            if let Some(command) = waiting.commands.pop_front() {
                return Next::Command(command);
            }
            if let Some(frame) = waiting.frame.take() {
                return Next::Frame(frame);
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Next::Nothing;
            }
            waiting = self
                .changed
                .wait_timeout(waiting, left)
                .map_or_else(|poisoned| poisoned.into_inner().0, |(waiting, _)| waiting);
        }
    }

    /// Frames so far.
    pub fn counts(&self) -> FrameCounts {
        self.lock().counts
    }

    fn lock(&self) -> MutexGuard<'_, Waiting<F, C>> {
        // nothing that holds the lock can panic half way through a change
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOON: Duration = Duration::from_secs(20);

    #[test]
    fn the_newest_frame_replaces_an_older_one_and_is_counted() {
        let inbox: Inbox<u32, &str> = Inbox::default();
        for frame in 1..=3 {
            inbox.put_frame(frame);
        }
        assert_eq!(inbox.next(SOON), Next::Frame(3));
        assert_eq!(inbox.next(Duration::ZERO), Next::Nothing);
        inbox.put_frame(4);
        assert_eq!(inbox.next(SOON), Next::Frame(4));
        let counts = inbox.counts();
        assert_eq!((counts.received, counts.dropped), (4, 2));
    }

    #[test]
    fn commands_keep_their_order_and_go_first() {
        let inbox: Inbox<u32, &str> = Inbox::default();
        inbox.put_frame(1);
        inbox.put_command("a");
        inbox.put_command("b");
        assert_eq!(inbox.next(SOON), Next::Command("a"));
        assert_eq!(inbox.next(SOON), Next::Command("b"));
        assert_eq!(inbox.next(SOON), Next::Frame(1));
    }

    #[test]
    fn a_waiting_worker_is_woken() {
        let inbox: Inbox<u32, &str> = Inbox::default();
        std::thread::scope(|scope| {
            let worker = scope.spawn(|| (inbox.next(SOON), inbox.next(SOON)));
            inbox.put_frame(7);
            while inbox.lock().frame.is_some() {
                std::thread::yield_now();
            }
            inbox.close();
            assert_eq!(worker.join().unwrap(), (Next::Frame(7), Next::Closed));
        });
    }

    #[test]
    fn closed_is_closed() {
        let inbox: Inbox<u32, &str> = Inbox::default();
        inbox.put_frame(1);
        inbox.put_command("a");
        inbox.close();
        assert_eq!(inbox.next(SOON), Next::Closed);
    }
}
