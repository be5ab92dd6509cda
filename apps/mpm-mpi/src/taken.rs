//! What a rank has sent, held and taken so far.

use mpm_petsc::Traffic;
use std::fs;

/// Ticks per second of `/proc`, the same on every machine that Linux runs on today (USER_HZ).
const TICKS: f64 = 100.0;

/// What one rank has sent, held and taken.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Taken {
    /// Bytes sent by the messages of our own; PETSc's are not among them.
    bytes: f64,
    messages: f64,
    /// Largest resident memory `[B]`; zero where the system does not tell.
    memory: f64,
    /// Processor time of all of its threads `[s]`; zero where the system does not tell.
    processor: f64,
}

impl Taken {
    /// Of this rank, which has sent so much.
    pub(crate) fn of(traffic: Traffic) -> Self {
        let Traffic { bytes, messages } = traffic;
        Self {
            bytes: bytes as f64,
            messages: messages as f64,
            memory: peak_memory().unwrap_or_default(),
            processor: processor_seconds().unwrap_or_default(),
        }
    }

    pub(crate) fn numbers(self) -> [f64; 4] {
        [self.bytes, self.messages, self.memory, self.processor]
    }

    /// A line about a rank.
    pub(crate) fn line(rank: usize, numbers: [f64; 4]) -> String {
        let [bytes, messages, memory, processor] = numbers;
        format!(
            "rank {rank} sent {bytes} bytes in {messages} messages, held {memory} bytes, took {processor:.2} s"
        )
    }
}

/// `/proc/self/status`, proc(5).
fn peak_memory() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse::<f64>().ok().map(|kilobytes| kilobytes * 1024.0)
}

/// Fields 14 and 15 of `/proc/self/stat`, proc(5); the second field is a name in brackets, which may hold spaces.
fn processor_seconds() -> Option<f64> {
    let text = fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |field: usize| fields.get(field - 3)?.parse::<f64>().ok();
    Some((ticks(14)? + ticks(15)?) / TICKS)
}
