//! Ranks as threads of one process.

use crate::wire::Wire;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// What a rank sends to another one: nothing in most pairs.
type Message = Option<Vec<u8>>;

/// A rank that is a thread. It is made by [`on_threads`].
pub struct Threads {
    rank: usize,
    /// To every rank.
    to: Vec<Sender<Message>>,
    /// From every rank.
    from: Vec<Receiver<Message>>,
}

/// Runs `work` on so many ranks, each a thread, and returns what they return, in the order of the ranks.
///
/// # Panics
/// If a rank panics; the others, which wait for it, do so with it.
pub fn on_threads<R: Send>(size: usize, work: impl Fn(Threads) -> R + Sync) -> Vec<R> {
    let mut wires: Vec<Threads> =
        (0..size).map(|rank| Threads { rank, to: Vec::new(), from: Vec::new() }).collect();
    for from in 0..size {
        for to in 0..size {
            let (sender, receiver) = channel();
            wires[from].to.push(sender);
            wires[to].from.push(receiver);
        }
    }
    let work = &work;
    thread::scope(|scope| {
        let started: Vec<_> = wires.into_iter().map(|wire| scope.spawn(move || work(wire))).collect();
        // All of them end before the first panic goes on: their channels close as they unwind.
        let ended: Vec<_> = started.into_iter().map(|rank| rank.join()).collect();
        let ended = ended.into_iter().map(|it| it.unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        ended.collect()
    })
}

impl Threads {
    /// One message to and from every rank.
    fn swap(&self, mut message: impl FnMut(usize) -> Message) -> Vec<Message> {
        let gone = |rank: usize| -> ! { panic!("rank {rank} has ended while rank {} waits for it", self.rank) };
        for (rank, to) in self.to.iter().enumerate() {
            to.send(message(rank)).unwrap_or_else(|_| gone(rank));
        }
        let received = self.from.iter().enumerate();
        received.map(|(rank, from)| from.recv().unwrap_or_else(|_| gone(rank))).collect()
    }
}

impl Wire for Threads {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.to.len()
    }

    fn gather(&self, own: &[f64], all: &mut [f64]) {
        let bytes: Vec<u8> = own.iter().flat_map(|x| x.to_le_bytes()).collect();
        let received = self.swap(|_| Some(bytes.clone()));
        let numbers = received.iter().flatten().flat_map(|bytes| bytes.chunks_exact(8));
        let mut count = 0;
        for (to, from) in all.iter_mut().zip(numbers) {
            *to = f64::from_le_bytes(from.try_into().expect("eight bytes"));
            count += 1;
        }
        assert_eq!(count, own.len() * self.size(), "every rank gives as many numbers");
    }

    fn exchange(&self, out: &[(usize, Vec<u8>)]) -> Vec<(usize, Vec<u8>)> {
        let to = |rank: usize| out.iter().find(|it| it.0 == rank).map(|it| it.1.clone());
        let received = self.swap(to);
        received.into_iter().enumerate().filter_map(|(rank, bytes)| Some((rank, bytes?))).collect()
    }
}
