//! Linear systems that rank 0 solves for all ranks, by the solver that the model has chosen: for systems that fit on one
//! machine, and the measure of all others.

mod answer;
mod system;

use crate::exchange::Exchange;
use crate::message::{Reader, Writer};
use crate::wire::Wire;
use answer::{Place, Told};
use mpm_linear::{
    Analysis, Factored, Hints, LinearSolver, Matrix, Method, NotSavedHere, OutOfMemory, Pattern, Saved,
    Singular, Solved,
};
use mpm_solver::Model;
use std::rc::Rc;
use system::System;

/// Gathers the matrix of all ranks on rank 0 and solves there. The system is that of one rank alone, in the same order, so that
/// what is chosen, and what is saved, is the same.
pub struct Gathered<const D: usize, W> {
    exchange: Rc<Exchange<D, W>>,
    /// On rank 0 the one that solves.
    solver: Box<dyn LinearSolver>,
    /// See [`Exchange::generation`].
    generation: Option<u64>,
    /// The nodes of this rank with a further unknown, in the order of these.
    further: Vec<u64>,
    /// On rank 0.
    system: System,
}

impl<const D: usize, W: Wire> Gathered<D, W> {
    /// Solves as the model wants it.
    pub fn new(model: &Model<D>, exchange: Rc<Exchange<D, W>>) -> Self {
        Self {
            exchange,
            solver: model.linear_solver(),
            generation: None,
            further: Vec::new(),
            system: System::default(),
        }
    }

    fn is_rank_zero(&self) -> bool {
        self.exchange.wire().rank() == 0
    }

    /// Sends what all ranks have to rank 0: there the bytes of every rank, in their order; elsewhere nothing.
    fn to_rank_zero(&self, bytes: Vec<u8>) -> Vec<Vec<u8>> {
        self.exchange.wire().exchange(&[(0, bytes)]).into_iter().map(|it| it.1).collect()
    }

    /// What rank 0 tells each rank.
    fn told_by_rank_zero(&self, told: Vec<Vec<u8>>) -> Vec<u8> {
        let out: Vec<(usize, Vec<u8>)> = told.into_iter().enumerate().collect();
        let mut incoming = self.exchange.wire().exchange(&out);
        incoming.pop().expect("rank 0 tells everybody").1
    }

    /// What rank 0 tells all ranks alike.
    fn same(&self, told: Option<Vec<u8>>) -> Vec<u8> {
        let size = self.exchange.wire().size();
        self.told_by_rank_zero(told.map_or(Vec::new(), |bytes| vec![bytes; size]))
    }

    /// The equation of this rank, if it has the node.
    fn equation(&self, place: Place) -> Option<usize> {
        let numbering = self.exchange.numbering();
        match place {
            Place::Behind(k) => Some(numbering.nodes.len() * D + self.further.len() + k),
            Place::Further { node } => {
                let entry = self.further.binary_search(&node).ok()?;
                Some(numbering.nodes.len() * D + entry)
            }
            Place::Node { node, component } => {
                let node = numbering.nodes.binary_search_by_key(&node, |it| it.index() as u64).ok()?;
                Some(node * D + component)
            }
        }
    }

    /// A failure at an equation of rank 0 as this rank reports it: who has the node, or rank 0 where no node is meant.
    fn failure(&self, place: Option<Place>, pivot: Option<f64>, cause: mpm_linear::Cause) -> Option<Singular> {
        let equation = match place {
            Some(place) => self.equation(place)?,
            None if self.is_rank_zero() => 0,
            None => return None,
        };
        Some(Singular { equation, pivot, cause })
    }
}

impl<const D: usize, W: Wire> LinearSolver for Gathered<D, W> {
    fn analyse(&mut self, pattern: Pattern<'_>, hints: &Hints<'_>) -> Result<Analysis, OutOfMemory> {
        let is_kept = hints.is_kept && self.generation == Some(self.exchange.generation());
        self.generation = Some(self.exchange.generation());
        if !is_kept {
            let mut own = Writer::default();
            self.further = system::further(&pattern, hints, &self.exchange.numbering());
            system::write(&pattern, hints, &self.exchange.numbering(), &mut own);
            let all = self.to_rank_zero(own.finish());
            if self.is_rank_zero() {
                self.system = System::of(&all, (pattern.symmetry, pattern.block));
            }
        }
        let answer = self.is_rank_zero().then(|| {
            let analysis = self.system.analyse(&mut *self.solver, hints, is_kept);
            answer::analysis(&analysis)
        });
        answer::read_analysis(&self.same(answer))
    }

    fn factorise(&mut self, matrix: Matrix<'_>) -> Result<Factored, Singular> {
        let mut own = Writer::default();
        own.numbers(matrix.values);
        let all = self.to_rank_zero(own.finish());
        let answer = self.is_rank_zero().then(|| {
            self.system.sum(&all);
            let factored = self.solver.factorise(self.system.matrix());
            answer::factored(&factored, &|equation| self.system.place(equation))
        });
        match answer::read_factored(&self.same(answer), &|place| self.equation(place)) {
            Told::Done(factored) => Ok(factored),
            Told::Failed { place, pivot, cause } => match self.failure(place, pivot, cause) {
                Some(failure) => Err(failure),
                // Another rank says so.
                None => Ok(Factored::by(self.solver.first_method())),
            },
        }
    }

    fn solve(&mut self, _: Matrix<'_>, rhs: &mut [f64], tolerance: f64) -> Result<Solved, Singular> {
        let mut own = Writer::default();
        own.numbers(rhs);
        let all = self.to_rank_zero(own.finish());
        let mut told = Vec::new();
        if self.is_rank_zero() {
            let mut x = self.system.right_hand_side(&all);
            let solved = self.solver.solve(self.system.matrix(), &mut x, tolerance);
            let answer = answer::solved(&solved, &|equation| self.system.place(equation));
            told = self.system.shared_out(&x, &answer);
        }
        let told = self.told_by_rank_zero(told);
        let mut reader = Reader::new(&told);
        match answer::read_solved(reader.bytes(), &|place| self.equation(place)) {
            Told::Done(solved) => {
                rhs.copy_from_slice(&reader.numbers());
                Ok(solved)
            }
            Told::Failed { place, pivot, cause } => match self.failure(place, pivot, cause) {
                Some(failure) => Err(failure),
                None => Ok(answer::nothing_solved(self.solver.first_method())),
            },
        }
    }

    fn first_method(&self) -> Method {
        self.solver.first_method()
    }

    fn restart(&mut self) {
        self.solver.restart();
    }

    fn end_step(&mut self) {
        self.solver.end_step();
    }

    fn save(&self) -> Option<Saved> {
        self.solver.save()
    }

    fn restore(&mut self, saved: Saved) -> Result<(), NotSavedHere> {
        self.solver.restore(saved)
    }

    fn condition(&mut self, _: Matrix<'_>) -> Option<f64> {
        let answer = self.is_rank_zero().then(|| {
            let mut told = Writer::default();
            told.number(self.solver.condition(self.system.matrix()).unwrap_or(f64::NAN));
            told.finish()
        });
        let condition = Reader::new(&self.same(answer)).number();
        (!condition.is_nan()).then_some(condition)
    }
}
