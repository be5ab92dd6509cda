//! Weak scaling by a model: what a load step of many points costs, from what one machine shows.

use super::programs::{Predicted, Run};
use crate::report::decades;
use mpm_validation::picture::{Curve, Curves, Legend, Panel, Stroke};
use mpm_validation::{Picture, Table};
use serde::Serialize;

/// Points of a rank.
const POINTS_OF_A_RANK: f64 = 1e6;

/// Points of all ranks for which the model is evaluated.
const POINTS: [f64; 4] = [1e6, 1e7, 1e8, 1e9];

/// Points of a cell, as in the scene that is measured.
const POINTS_OF_A_CELL: f64 = 8.0;

/// Ranks that share a node with one in the midst of others.
const NEIGHBOURS: f64 = 26.0;

/// Exchanges with the neighbours on each level in an iteration: products, smoothing before and after, residual, way down and up.
const HALOS: f64 = 8.0;

/// Sums over all ranks in an iteration of conjugate gradients.
const SUMS: f64 = 3.0;

/// Nodes along an edge of the coarsest lattice, and bytes of its right-hand side, which every rank has.
const COARSEST: [f64; 2] = [7.0, 7.0 * 7.0 * 7.0 * 24.0];

/// What a rank holds for every point of the scene while it makes its share `[B]`, in space.
const HELD_AT_START: f64 = 56.0;

/// Memory of a rank beside its points: program, MPI, PETSc `[B]`.
const PROGRAM: f64 = 65e6;

/// Memory that a machine has for each of its ranks, where the model calls it a limit `[B]`.
const MEMORY: f64 = 4e9;

/// What is assumed of the network, not measured: time of a message `[s]`, and bytes per second of one rank.
const LATENCY: f64 = 2e-6;
const BANDWIDTH: f64 = 1e9;

/// What the model is told, measured in the same run of this set.
#[derive(Clone, Debug, Serialize)]
pub struct Inputs {
    /// Newton iterations and, in all of them, iterations of conjugate gradients in a load step.
    pub iterations: [f64; 2],
    /// Seconds per point of a rank in a load step: what its points take (connect, stress, assemble, advance).
    pub points: f64,
    /// The same of analysing and preparing: places of the blocks, products, factors.
    pub set_up: f64,
    /// The same of the iterations of conjugate gradients.
    pub solve: f64,
    /// Seconds per point of the scene that every rank takes to walk through its pieces at the start.
    pub walk: f64,
    /// Seconds per point of a rank that it takes to make it.
    pub make: f64,
    /// Seconds per point of the scene that rank 0 takes to write displacement and stress once.
    pub write: f64,
    /// Bytes per shared node in a load step, by messages of our own.
    pub sent: f64,
    /// Messages of our own to one neighbour in a load step.
    pub messages: f64,
    /// Bytes per point of a rank.
    pub held: f64,
    /// Bytes per point of the scene that rank 0 holds more where fields are recorded.
    pub gathered: f64,
}

/// The runs of the same scene that the inputs are taken from: on one rank and on two, on two in two load steps, and on two with
/// fields recorded.
pub(crate) struct Measured<'a> {
    pub(crate) one: &'a Run,
    pub(crate) two: &'a Run,
    pub(crate) longer: &'a Run,
    pub(crate) recorded: &'a Run,
    pub(crate) predicted: &'a [Predicted],
}

impl Inputs {
    /// Seconds of the phases are those on two ranks, which share the memory of the machine.
    pub(crate) fn of(from: &Measured<'_>) -> Self {
        let Measured { one, two, longer, recorded, predicted } = from;
        let all = two.points as f64;
        let of_rank = all / 2.0;
        let phases = |names: &[&str]| names.iter().map(|name| two.seconds(name)).sum::<f64>() / of_rank;
        let make = one.start() / all;
        // On one rank there is no walk beside the making; on two each makes half.
        let walk = two.start() / all - 0.5 * make;
        let of_step = |of: fn(&super::Rank) -> f64| {
            let sum = |run: &Run| run.each.iter().map(of).sum::<f64>();
            (sum(longer) - sum(two)).max(0.0)
        };
        let shared: f64 = predicted.iter().map(|it| it.shared).sum();
        let held = two.each.iter().map(|it| it.memory).fold(0.0, f64::max);
        Self {
            iterations: [two.newton as f64, two.linear],
            points: phases(&["connect", "stress", "assemble", "advance"]),
            set_up: phases(&["analyse", "factorise"]),
            solve: phases(&["solve"]),
            walk: walk.max(0.1 * two.start() / all),
            make,
            write: (recorded.seconds("output") - two.seconds("output")).max(0.0) / all,
            sent: of_step(|it| it.bytes) / shared,
            messages: 0.5 * of_step(|it| it.messages),
            held: (held - PROGRAM) / of_rank,
            gathered: (recorded.each[0].memory - two.each[0].memory).max(0.0) / all,
        }
    }

    /// A table of them.
    pub fn table(&self) -> Table {
        let text = format!(
            "What the model is told. Measured: seconds of the phases on two ranks, bytes and messages between them. Assumed: {:.0} µs a message, {:.0} GB/s a rank, {NEIGHBOURS} neighbours, {HALOS} exchanges on a level and {SUMS} sums an iteration, {HELD_AT_START} bytes for every point of the scene on each rank at the start.",
            1e6 * LATENCY,
            1e-9 * BANDWIDTH
        );
        let mut table = Table::new(text, &["input", "value", "unit"]);
        let micro = |seconds: f64| format!("{:.3}", 1e6 * seconds);
        for (name, value, unit) in [
            ("Newton iterations", format!("{:.0}", self.iterations[0]), "a load step"),
            ("iterations of conjugate gradients", format!("{:.0}", self.iterations[1]), "a load step"),
            ("points: connect, stress, assemble, advance", micro(self.points), "µs a point and load step"),
            ("set-up: analyse, factorise", micro(self.set_up), "µs a point and load step"),
            ("iteration: solve", micro(self.solve), "µs a point and load step"),
            ("walk through all pieces", micro(self.walk), "µs a point of the scene"),
            ("making points", micro(self.make), "µs a point of the rank"),
            ("writing displacement and stress", micro(self.write), "µs a point of the scene"),
            ("sent", format!("{:.0}", self.sent), "bytes a shared node and load step"),
            ("messages", format!("{:.0}", self.messages), "to a neighbour, a load step"),
            ("memory", format!("{:.0}", self.held), "bytes a point of the rank"),
            (
                "memory of rank 0 for what is recorded",
                format!("{:.0}", self.gathered),
                "bytes a point of the scene",
            ),
        ] {
            table.push([name.to_owned(), value, unit.to_owned()]);
        }
        table
    }
}

/// What the model says of so many points.
#[derive(Clone, Debug, Serialize)]
pub struct Told {
    /// Points of all ranks.
    pub points: f64,
    /// Ranks.
    pub ranks: f64,
    /// Seconds: name of a part and what it takes in a load step, but for the first two, which the start of the run and a recorded
    /// load step take.
    pub seconds: [(&'static str, f64); 7],
    /// Memory of a rank while it runs, and at the start `[B]`.
    pub memory: [f64; 2],
    /// Memory of rank 0 where fields are recorded `[B]`.
    pub memory_of_first: f64,
}

/// The parts that do what is wanted; the others are what limits.
const USEFUL: [&str; 3] = ["points", "set-up", "iteration"];

impl Told {
    /// Of so many points, as many on each rank as the model takes.
    pub(crate) fn of(inputs: &Inputs, points: f64) -> Self {
        let ranks = (points / POINTS_OF_A_RANK).ceil().max(1.0);
        let own = points / ranks;
        let [newton, linear] = inputs.iterations;
        let rounds = ranks.log2();
        let nodes_of_face = (own / POINTS_OF_A_CELL).powf(2.0 / 3.0);
        let (shared, neighbours) = if ranks > 1.0 { (6.0 * nodes_of_face, NEIGHBOURS) } else { (0.0, 0.0) };
        // Every exchange tells all ranks the length of what comes.
        let exchange = neighbours * LATENCY + 2.0 * rounds * LATENCY + 8.0 * (ranks - 1.0) / BANDWIDTH;
        let of_finest = (linear + newton) * HALOS * shared * 24.0 / BANDWIDTH;
        let messages = shared * inputs.sent / BANDWIDTH + inputs.messages * exchange + of_finest;
        let levels = ((points / POINTS_OF_A_CELL).cbrt() / COARSEST[0]).log2().ceil().max(0.0);
        let of_levels = levels * HALOS * neighbours * LATENCY;
        let of_coarsest = (1.0 + SUMS) * rounds * LATENCY + COARSEST[1] * (ranks - 1.0).min(1.0) / BANDWIDTH;
        let coarsest = linear * (of_levels + of_coarsest);
        let walk = if ranks > 1.0 { points } else { 0.0 };
        let running = PROGRAM + inputs.held * own;
        Self {
            points,
            ranks,
            seconds: [
                ("start", inputs.walk * walk + inputs.make * own),
                ("writer", inputs.write * points),
                ("points", inputs.points * own),
                ("set-up", inputs.set_up * own),
                ("iteration", inputs.solve * own),
                ("messages", messages),
                ("coarsest levels", coarsest),
            ],
            memory: [running, PROGRAM + HELD_AT_START * walk],
            memory_of_first: running + inputs.gathered * points,
        }
    }

    /// Seconds of a load step, without start and records.
    fn of_step(&self) -> f64 {
        self.seconds[2..].iter().map(|it| it.1).sum()
    }

    /// What is in the way, the worst first: what takes a tenth of a load step or more and is no work on points and systems, and memory.
    pub(crate) fn limits(&self) -> Vec<String> {
        let step = self.of_step();
        let is_felt = |it: &&(&str, f64)| !USEFUL.contains(&it.0) && it.1 > 0.1 * step;
        let mut felt: Vec<(String, f64)> =
            self.seconds.iter().filter(is_felt).map(|it| (it.0.to_owned(), it.1 / step)).collect();
        let memory = [
            ("memory at the start", self.memory[1]),
            ("memory of a rank", self.memory[0]),
            ("memory of rank 0 (writer)", self.memory_of_first),
        ];
        felt.extend(memory.iter().filter(|it| it.1 > MEMORY).map(|it| (it.0.to_owned(), it.1 / MEMORY)));
        felt.sort_by(|a, b| b.1.total_cmp(&a.1));
        felt.into_iter().map(|it| it.0).collect()
    }
}

/// What the model says of all numbers of points.
pub(crate) fn told(inputs: &Inputs) -> Vec<Told> {
    POINTS.iter().map(|&points| Told::of(inputs, points)).collect()
}

/// A table of them.
pub(crate) fn table(told: &[Told]) -> Table {
    let text = format!(
        "Weak scaling by the model, {POINTS_OF_A_RANK:e} points a rank: seconds of the start, of a recorded load step (writer), and of the parts of a load step; memory. In the last column what takes a tenth of a load step or more beside work on points and systems, and memory above {:.0} GB a rank, the worst first.",
        1e-9 * MEMORY
    );
    let parts = told.first().map_or(Vec::new(), |it| it.seconds.iter().map(|it| it.0).collect());
    let last = ["load step", "GB of a rank", "GB at the start", "GB of rank 0", "limits"];
    let heads: Vec<&str> = ["points", "ranks"].into_iter().chain(parts).chain(last).collect();
    let mut table = Table::new(text, &heads);
    for it in told {
        let mut row = vec![format!("{:e}", it.points), format!("{:.0}", it.ranks)];
        row.extend(it.seconds.iter().map(|it| format!("{:.3}", it.1)));
        row.push(format!("{:.2}", it.of_step()));
        row.extend([it.memory[0], it.memory[1], it.memory_of_first].map(|it| format!("{:.2}", 1e-9 * it)));
        row.push(it.limits().join(", "));
        table.rows.push(row);
    }
    table
}

/// Curves of seconds and of memory against points.
pub(crate) fn picture(told: &[Told]) -> Picture {
    let names: Vec<&str> = told.first().map_or(Vec::new(), |it| it.seconds.iter().map(|it| it.0).collect());
    let seconds: Vec<(&str, Vec<f64>)> = names
        .iter()
        .enumerate()
        .map(|(k, &name)| (name, told.iter().map(|it| it.seconds[k].1).collect()))
        .collect();
    let memory = vec![
        ("of a rank", told.iter().map(|it| 1e-9 * it.memory[0]).collect()),
        ("of a rank at the start", told.iter().map(|it| 1e-9 * it.memory[1]).collect()),
        ("of rank 0 where fields are recorded", told.iter().map(|it| 1e-9 * it.memory_of_first).collect()),
    ];
    let panel = |title: &str, axis: &str, all: Vec<(&str, Vec<f64>)>| {
        let range =
            [decades(told.iter().map(|it| it.points)), decades(all.iter().flat_map(|it| it.1.iter().copied()))];
        let curves = all.into_iter().enumerate().map(|(colour, (name, values))| Curve {
            name: name.into(),
            colour,
            stroke: Stroke::MarkedLine,
            points: told.iter().map(|it| it.points).zip(values).filter(|it| it.1 > 0.0).collect(),
        });
        Panel::Curves(Curves {
            title: title.into(),
            axes: ["points".into(), axis.into()],
            range,
            logarithmic: [true; 2],
            legend: Legend::UpperLeft,
            curves: curves.collect(),
        })
    };
    let panels = vec![
        panel("Start, record, and parts of a load step", "seconds", seconds),
        panel("Memory", "GB", memory),
    ];
    Picture { file: "ranks.svg", caption: String::new(), panels }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inputs() -> Inputs {
        Inputs {
            iterations: [4.0, 20.0],
            points: 6e-6,
            set_up: 5e-6,
            solve: 9e-6,
            walk: 3e-7,
            make: 5e-7,
            write: 2e-6,
            sent: 400.0,
            messages: 30.0,
            held: 2500.0,
            gathered: 200.0,
        }
    }

    #[test]
    fn work_of_a_rank_does_not_grow_and_what_all_do_does() {
        let told = told(&inputs());
        let (few, many) = (&told[1], &told[3]);
        assert_eq!(few.seconds[2], many.seconds[2]);
        assert!(many.seconds[0].1 > 50.0 * few.seconds[0].1, "{many:?}");
        assert!((many.seconds[1].1 / few.seconds[1].1 - 100.0).abs() < 1e-9);
        assert_eq!(few.memory[0], many.memory[0]);
        assert!(many.limits().contains(&"writer".to_owned()), "{:?}", many.limits());
    }

    #[test]
    fn one_rank_sends_nothing() {
        let alone = &told(&inputs())[0];
        assert_eq!((alone.ranks, alone.seconds[5].1), (1.0, 0.0));
        assert!(alone.limits().is_empty() || alone.limits() == ["writer"], "{:?}", alone.limits());
    }
}
