//! What the solver on rank 0 answers, as bytes.

use crate::message::{Reader, Writer};
use mpm_linear::{Analysis, Cause, Factored, Inertia, Method, OutOfMemory, Pivot, Sign, Singular, Solved};

/// Where an equation stands, whichever rank has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// A component of a node.
    Node { node: u64, component: usize },
    /// The further unknown of a node.
    Further { node: u64 },
    /// The k-th of the unknowns behind those of the nodes, which all ranks have.
    Behind(usize),
}

/// Which kind of place follows in a message.
const OF_NODE: u64 = 0;
const FURTHER: u64 = 1;
const BEHIND: u64 = 2;

/// An answer.
pub(super) enum Told<T> {
    Done(T),
    /// No solution, as this component shows; none where no single one does.
    Failed {
        place: Option<Place>,
        pivot: Option<f64>,
        cause: Cause,
    },
}

/// An equation that no rank has: what is told of it names no node.
const NOWHERE: usize = usize::MAX;

pub(super) fn analysis(analysis: &Result<Analysis, OutOfMemory>) -> Vec<u8> {
    let mut to = Writer::default();
    match analysis {
        Ok(Analysis::New) => to.count(0),
        Ok(Analysis::Reused) => to.count(1),
        Err(OutOfMemory { equations, factor_entries }) => {
            to.count(2);
            to.count(*equations as u64);
            to.count(*factor_entries as u64);
        }
    }
    to.finish()
}

pub(super) fn read_analysis(bytes: &[u8]) -> Result<Analysis, OutOfMemory> {
    let mut from = Reader::new(bytes);
    match from.count() {
        0 => Ok(Analysis::New),
        1 => Ok(Analysis::Reused),
        _ => Err(OutOfMemory { equations: from.index(), factor_entries: from.index() }),
    }
}

/// The methods of `mpm-linear`; that of another solver has no name here.
const METHODS: [Method; 6] = [
    Method::ConjugateGradients,
    Method::Gmres,
    Method::Llt,
    Method::Lblt,
    Method::Lu,
    Method::Other("a solver on rank 0"),
];

fn write_method(method: Method, to: &mut Writer) {
    let number = METHODS.iter().position(|it| *it == method).unwrap_or(METHODS.len() - 1);
    to.count(number as u64);
}

fn write_optional(value: Option<f64>, to: &mut Writer) {
    to.count(u64::from(value.is_some()));
    to.number(value.unwrap_or(0.0));
}

fn read_optional(from: &mut Reader<'_>) -> Option<f64> {
    let is_some = from.count() > 0;
    let value = from.number();
    is_some.then_some(value)
}

fn write_place(place: Option<Place>, to: &mut Writer) {
    let numbers = match place {
        None => vec![],
        Some(Place::Node { node, component }) => vec![OF_NODE, node, component as u64],
        Some(Place::Further { node }) => vec![FURTHER, node],
        Some(Place::Behind(k)) => vec![BEHIND, k as u64],
    };
    to.counts(numbers.into_iter());
}

fn read_place(from: &mut Reader<'_>) -> Option<Place> {
    match from.counts()[..] {
        [OF_NODE, node, component] => Some(Place::Node { node, component: component as usize }),
        [FURTHER, node] => Some(Place::Further { node }),
        [BEHIND, k] => Some(Place::Behind(k as usize)),
        _ => None,
    }
}

fn write_factored(factored: &Factored, place: &dyn Fn(usize) -> Option<Place>, to: &mut Writer) {
    write_method(factored.method, to);
    let inertia = factored.inertia.map(|it| [it.positive, it.negative]);
    to.counts(inertia.iter().flatten().map(|&n| n as u64).collect::<Vec<_>>().into_iter());
    to.count(match factored.determinant_sign {
        None => 0,
        Some(Sign::Positive) => 1,
        Some(Sign::Negative) => 2,
    });
    to.count(u64::from(factored.not_positive.is_some()));
    write_place(factored.not_positive.and_then(|pivot| place(pivot.equation)), to);
    to.number(factored.not_positive.map_or(0.0, |pivot| pivot.value));
    to.number(factored.not_positive.map_or(0.0, |pivot| pivot.relative));
    to.count(u64::from(factored.indefinite_at.is_some()));
    write_place(factored.indefinite_at.and_then(place), to);
    write_optional(factored.pivot_ratio, to);
}

/// `equation` tells where a place stands on this rank, if it has it.
fn read_factored_of(from: &mut Reader<'_>, equation: &dyn Fn(Place) -> Option<usize>) -> Factored {
    let method = METHODS[from.index()];
    let inertia = match from.counts()[..] {
        [positive, negative] => Some(Inertia { positive: positive as usize, negative: negative as usize }),
        _ => None,
    };
    let determinant_sign = match from.count() {
        0 => None,
        1 => Some(Sign::Positive),
        _ => Some(Sign::Negative),
    };
    let is_not_positive = from.count() > 0;
    let equation_here = |place: Option<Place>| place.and_then(equation).unwrap_or(NOWHERE);
    let stopped_at = equation_here(read_place(from));
    let pivot = Pivot { equation: stopped_at, value: from.number(), relative: from.number() };
    let is_indefinite = from.count() > 0;
    let indefinite_at = equation_here(read_place(from));
    Factored {
        method,
        inertia,
        determinant_sign,
        not_positive: is_not_positive.then_some(pivot),
        indefinite_at: is_indefinite.then_some(indefinite_at),
        weakest: None,
        pivot_ratio: read_optional(from),
    }
}

fn write_failure(failure: &Singular, place: &dyn Fn(usize) -> Option<Place>, to: &mut Writer) {
    let (cause, number) = match failure.cause {
        Cause::EmptyRow => (0, 0.0),
        Cause::NoPivot => (1, 0.0),
        Cause::MatrixNotFinite => (2, 0.0),
        Cause::RightHandSideNotFinite => (3, 0.0),
        Cause::Inaccurate { backward_error } => (4, backward_error),
        Cause::NoMemory { entries } => (5, entries),
        Cause::TooLargeToFactorise { entries } => (6, entries),
        Cause::Unsuitable(_) => (7, 0.0),
    };
    write_place(place(failure.equation).filter(|_| cause != 7), to);
    write_optional(failure.pivot, to);
    to.count(cause);
    to.number(number);
}

fn read_failure<T>(from: &mut Reader<'_>) -> Told<T> {
    let place = read_place(from);
    let pivot = read_optional(from);
    let (cause, number) = (from.count(), from.number());
    let cause = match cause {
        0 => Cause::EmptyRow,
        1 => Cause::NoPivot,
        2 => Cause::MatrixNotFinite,
        3 => Cause::RightHandSideNotFinite,
        4 => Cause::Inaccurate { backward_error: number },
        5 => Cause::NoMemory { entries: number },
        6 => Cause::TooLargeToFactorise { entries: number },
        _ => Cause::Unsuitable("the solver on rank 0 does not take this kind of matrix"),
    };
    Told::Failed { place, pivot, cause }
}

pub(super) fn factored(
    factored: &Result<Factored, Singular>,
    place: &dyn Fn(usize) -> Option<Place>,
) -> Vec<u8> {
    let mut to = Writer::default();
    to.count(u64::from(factored.is_ok()));
    match factored {
        Ok(factored) => write_factored(factored, place, &mut to),
        Err(failure) => write_failure(failure, place, &mut to),
    }
    to.finish()
}

pub(super) fn read_factored(bytes: &[u8], equation: &dyn Fn(Place) -> Option<usize>) -> Told<Factored> {
    let mut from = Reader::new(bytes);
    if from.count() > 0 { Told::Done(read_factored_of(&mut from, equation)) } else { read_failure(&mut from) }
}

pub(super) fn solved(solved: &Result<Solved, Singular>, place: &dyn Fn(usize) -> Option<Place>) -> Vec<u8> {
    let mut to = Writer::default();
    to.count(u64::from(solved.is_ok()));
    match solved {
        Ok(solved) => {
            write_method(solved.method, &mut to);
            write_optional(solved.backward_error, &mut to);
            write_optional(solved.residual, &mut to);
            to.count(solved.refinements as u64);
            to.count(u64::from(solved.iterations));
            to.count(u64::from(solved.taken_over.is_some()));
            solved.taken_over.iter().for_each(|factored| write_factored(factored, place, &mut to));
        }
        Err(failure) => write_failure(failure, place, &mut to),
    }
    to.finish()
}

pub(super) fn read_solved(bytes: &[u8], equation: &dyn Fn(Place) -> Option<usize>) -> Told<Solved> {
    let mut from = Reader::new(bytes);
    if from.count() == 0 {
        return read_failure(&mut from);
    }
    Told::Done(Solved {
        method: METHODS[from.index()],
        backward_error: read_optional(&mut from),
        residual: read_optional(&mut from),
        refinements: from.index(),
        iterations: from.count() as u32,
        taken_over: (from.count() > 0).then(|| read_factored_of(&mut from, equation)),
    })
}

/// What a rank answers while another one tells that nothing was solved.
pub(super) fn nothing_solved(method: Method) -> Solved {
    Solved { method, backward_error: None, residual: None, refinements: 0, iterations: 0, taken_over: None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_read_as_they_were_written() {
        let somewhere = |equation: usize| match equation {
            5 => Some(Place::Further { node: 2 }),
            7 => Some(Place::Behind(3)),
            _ => Some(Place::Node { node: equation as u64 / 2, component: equation % 2 }),
        };
        let here = |place: Place| match place {
            Place::Further { node } => Some(3 + node as usize),
            Place::Behind(k) => Some(4 + k),
            Place::Node { node, component } => Some(node as usize * 2 + component),
        };
        let pivot = Pivot { equation: 9, value: -2.0, relative: -1e-3 };
        let found = Factored {
            inertia: Some(Inertia { positive: 8, negative: 1 }),
            determinant_sign: Some(Sign::Negative),
            not_positive: Some(pivot),
            indefinite_at: Some(5),
            pivot_ratio: Some(1e-5),
            ..Factored::by(Method::Lblt)
        };
        let bytes = factored(&Ok(found), &somewhere);
        assert!(matches!(read_factored(&bytes, &here), Told::Done(it) if it == found));
        let elsewhere = Factored {
            not_positive: Some(Pivot { equation: NOWHERE, ..pivot }),
            indefinite_at: Some(NOWHERE),
            ..found
        };
        assert!(matches!(read_factored(&bytes, &|_| None), Told::Done(it) if it == elsewhere));
        let whole = Solved {
            residual: Some(1e-9),
            iterations: 12,
            taken_over: Some(found),
            ..nothing_solved(Method::Gmres)
        };
        assert!(matches!(read_solved(&solved(&Ok(whole), &somewhere), &here), Told::Done(it) if it == whole));
        let failure =
            Singular { equation: 7, pivot: Some(0.0), cause: Cause::Inaccurate { backward_error: 0.5 } };
        let Told::Failed { place, pivot, cause } = read_solved(&solved(&Err(failure), &somewhere), &here)
        else {
            panic!("it failed")
        };
        assert_eq!((place, pivot, cause), (somewhere(7), failure.pivot, failure.cause));
        let full = Err(OutOfMemory { equations: 3, factor_entries: 5 });
        assert_eq!(read_analysis(&analysis(&full)), full);
    }
}
