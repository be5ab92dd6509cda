//! An observer of the points of all ranks, on rank 0.
//!
//! What an observer asks of the points is asked of all ranks: rank 0 sends a request, and all answer, until it is done.

use crate::exchange::Exchange;
use crate::key::{Key, read_keys, write_keys};
use crate::message::{Reader, Writer};
use crate::points::{Points, Rows};
use crate::wire::Wire;
use mpm_solver::observe::{
    Cancellation, Field, Fields, LoadStep, Moment, Observer, ObserverError, Outcome, Resumed, RunStart, Timing,
};
use mpm_solver::{State, StoredPredictor, StoredShare};
use std::cell::RefCell;
use std::rc::Rc;

/// Rank 0 is done; a message follows if it has failed.
const DONE: u64 = 0;
const POSITIONS: u64 = 1;
const OUTLINES: u64 = 2;
const STATE: u64 = 3;
/// From here on the fields that points have.
const FIELDS: u64 = 4;

/// Shows an observer on rank 0 the points of all ranks, in the order in which one rank alone has them. It is made by
/// [`Cluster::whole`](crate::Cluster::whole) on every rank.
pub struct Whole<'a, const D: usize, W: Wire> {
    pub(crate) exchange: Rc<Exchange<D, W>>,
    pub(crate) points: Rc<RefCell<Points<D>>>,
    /// On rank 0 the observer.
    pub(crate) inner: &'a mut dyn Observer,
}

/// What is asked of the observer with the points of all ranks.
type Call<'a> = dyn FnMut(&mut dyn Observer, &dyn Fields) -> Result<(), ObserverError> + 'a;

impl<const D: usize, W: Wire> Whole<'_, D, W> {
    /// Calls the observer on rank 0, and answers its requests on the others.
    fn with_all(
        &mut self,
        answer: &dyn Fn(u64) -> Vec<u8>,
        call: &mut dyn FnMut(&mut dyn Observer) -> Result<(), ObserverError>,
    ) -> Result<(), ObserverError> {
        let wire = self.exchange.wire();
        if wire.rank() == 0 {
            let outcome = call(self.inner);
            let mut done = Writer::default();
            done.count(DONE);
            outcome.as_ref().err().iter().for_each(|error| done.bytes(error.to_string().as_bytes()));
            ask(wire, done.finish());
            return outcome;
        }
        loop {
            let request = wire.exchange(&[]).pop().expect("rank 0 asks").1;
            let mut reader = Reader::new(&request);
            match reader.count() {
                DONE if reader.is_at_end() => return Ok(()),
                DONE => return Err(String::from_utf8_lossy(reader.bytes()).into_owned().into()),
                asked => {
                    wire.exchange(&[(0, answer(asked))]);
                }
            }
        }
    }

    /// Calls the observer on rank 0 with the points of all.
    fn with_fields(&mut self, own: &dyn Fields, call: &mut Call<'_>) -> Result<(), ObserverError> {
        let (exchange, points) = (self.exchange.clone(), self.points.clone());
        let order = order(exchange.wire(), &points.borrow().keys);
        let known = points.borrow().fields.clone();
        let all = AllFields { wire: exchange.wire(), own, order, known: known.clone() };
        self.with_all(&|asked| answer(own, &known, asked), &mut |inner| call(inner, &all))
    }
}

/// Sends a request to all other ranks.
fn ask(wire: &impl Wire, request: Vec<u8>) {
    let out: Vec<(usize, Vec<u8>)> = (1..wire.size()).map(|rank| (rank, request.clone())).collect();
    wire.exchange(&out);
}

/// What a rank answers about its own points.
fn answer(own: &dyn Fields, known: &[Field], asked: u64) -> Vec<u8> {
    let mut to = Writer::default();
    match asked {
        POSITIONS => to.numbers(&own.positions()),
        OUTLINES => {
            for outline in own.outlines() {
                to.numbers(&outline.concat());
            }
        }
        _ => to.numbers(&own.field(known[(asked - FIELDS) as usize])),
    }
    to.finish()
}

/// On rank 0, rank and place there of the points of all ranks: body by body in the order of their keys.
fn order(wire: &impl Wire, keys: &[Vec<Key>]) -> Vec<(usize, usize)> {
    let mut own = Writer::default();
    for keys in keys {
        write_keys(keys, &mut own);
    }
    let mut all = Vec::new();
    for (rank, bytes) in wire.exchange(&[(0, own.finish())]) {
        let (mut from, mut place) = (Reader::new(&bytes), 0);
        for body in 0..keys.len() {
            for key in read_keys(&mut from) {
                all.push((body, key, rank, place));
                place += 1;
            }
        }
    }
    // Each rank has the points of a body in order: this sort merges what is sorted.
    all.sort();
    all.into_iter().map(|(_, _, rank, place)| (rank, place)).collect()
}

/// The points of all ranks, on rank 0.
struct AllFields<'a, W> {
    wire: &'a W,
    own: &'a dyn Fields,
    order: Vec<(usize, usize)>,
    known: Vec<Field>,
}

impl<W: Wire> AllFields<'_, W> {
    /// The answers of all ranks, in their order.
    fn asked(&self, request: u64) -> Vec<Vec<u8>> {
        let mut to = Writer::default();
        to.count(request);
        ask(self.wire, to.finish());
        let own = answer(self.own, &self.known, request);
        self.wire.exchange(&[(0, own)]).into_iter().map(|it| it.1).collect()
    }

    fn in_order(&self, request: u64, width: usize) -> Vec<f64> {
        let answers: Vec<Vec<f64>> =
            self.asked(request).iter().map(|bytes| Reader::new(bytes).numbers()).collect();
        let mut all = Vec::with_capacity(width * self.order.len());
        for &(rank, place) in &self.order {
            all.extend_from_slice(&answers[rank][place * width..(place + 1) * width]);
        }
        all
    }
}

impl<W: Wire> Fields for AllFields<'_, W> {
    fn n_points(&self) -> usize {
        self.order.len()
    }

    fn positions(&self) -> Vec<f64> {
        self.in_order(POSITIONS, 3)
    }

    fn field(&self, field: Field) -> Vec<f64> {
        match self.known.iter().position(|it| *it == field) {
            Some(k) => self.in_order(FIELDS + k as u64, field.components()),
            // No point has it.
            None => vec![0.0; self.order.len() * field.components()],
        }
    }

    fn outlines(&self) -> Vec<Vec<[f64; 3]>> {
        let read = |bytes: &Vec<u8>| {
            let (mut from, mut outlines) = (Reader::new(bytes), Vec::new());
            while !from.is_at_end() {
                let corners = from.numbers();
                outlines.push(corners.chunks_exact(3).map(|x| [x[0], x[1], x[2]]).collect::<Vec<_>>());
            }
            outlines
        };
        let answers: Vec<Vec<Vec<[f64; 3]>>> = self.asked(OUTLINES).iter().map(read).collect();
        self.order.iter().map(|&(rank, place)| answers[rank][place].clone()).collect()
    }
}

impl<const D: usize, W: Wire> Observer for Whole<'_, D, W> {
    fn start(&mut self, run: &RunStart) -> Result<(), ObserverError> {
        self.with_all(&|_| Vec::new(), &mut |inner| inner.start(run))
    }

    fn resume(&mut self, run: &RunStart, so_far: &Resumed) -> Result<(), ObserverError> {
        self.with_all(&|_| Vec::new(), &mut |inner| inner.resume(run, so_far))
    }

    fn cancellation(&self) -> Cancellation {
        self.inner.cancellation()
    }

    fn save(&mut self, at: Moment, state: &dyn Fn() -> State) -> Result<(), ObserverError> {
        let (exchange, points) = (self.exchange.clone(), self.points.clone());
        let wire = exchange.wire();
        let collected = || {
            let mut to = Writer::default();
            to.count(STATE);
            ask(wire, to.finish());
            joined(state(), &points.borrow(), wire)
        };
        // What the other ranks hand over is sent while it is collected.
        let hand_over = |_: u64| {
            joined(state(), &points.borrow(), wire);
            Vec::new()
        };
        self.with_all(&hand_over, &mut |inner| {
            inner.save(at, &|| {
                let state = collected();
                // The empty answer to the request.
                wire.exchange(&[]);
                state
            })
        })
    }

    fn load_step(&mut self, step: &LoadStep<'_>) -> Result<(), ObserverError> {
        self.with_fields(step.fields, &mut |inner, fields| inner.load_step(&LoadStep { fields, ..*step }))
    }

    fn last(&mut self, fraction: f64, fields: &dyn Fields) -> Result<(), ObserverError> {
        self.with_fields(fields, &mut |inner, fields| inner.last(fraction, fields))
    }

    fn finish(&mut self, outcome: &Outcome, timings: &[Timing]) -> Result<(), ObserverError> {
        self.with_all(&|_| Vec::new(), &mut |inner| inner.finish(outcome, timings))
    }
}

/// The state of all ranks, on rank 0, of what each has.
fn joined<const D: usize>(mut own: State, points: &Points<D>, wire: &impl Wire) -> State {
    let bodies = std::mem::take(&mut own.bodies).into_iter().zip(&points.keys);
    let rows = bodies.map(|(stored, keys)| Rows::new(keys.clone(), stored)).collect();
    let (bodies, keys) = Rows::on_rank_zero(rows, wire).into_iter().map(Rows::into_parts).unzip();
    own.bodies = bodies;
    points.memories.join(&mut own.contributions, (&points.keys, &keys), wire);
    own.shares =
        points.shares(&keys).iter().map(|shares| shares.iter().map(StoredShare::of).collect()).collect();
    own.predictor = last_step(&own.predictor, wire, D);
    own
}

/// The displacement of the last step of all ranks: what several have of a node is the same.
fn last_step(own: &StoredPredictor, wire: &impl Wire, width: usize) -> StoredPredictor {
    let mut to = Writer::default();
    to.counts(own.nodes.iter().copied());
    to.numbers(&own.increment);
    let mut all: Vec<(u64, Vec<f64>)> = Vec::new();
    for (_, bytes) in wire.exchange(&[(0, to.finish())]) {
        let mut from = Reader::new(&bytes);
        let (nodes, increment) = (from.counts(), from.numbers());
        all.extend(nodes.into_iter().zip(increment.chunks_exact(width).map(<[f64]>::to_vec)));
    }
    all.sort_by_key(|it| it.0);
    all.dedup_by_key(|it| it.0);
    StoredPredictor {
        nodes: all.iter().map(|it| it.0).collect(),
        increment: all.into_iter().flat_map(|it| it.1).collect(),
    }
}
