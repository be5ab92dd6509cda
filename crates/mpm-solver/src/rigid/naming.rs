//! Rigid motions in words.

use super::modes::{Frames, Mode, Motion, cross, turns};
use crate::model::NamedBody;
use mpm_assembly::Space;
use mpm_grid::{Vector, six_digits};

/// Parts and motions that a message tells of, at most.
const MOST_TOLD: usize = 3;

/// What holds none of these modes holds, as clauses: "body `b` along x and y".
pub(super) fn clauses<const D: usize>(
    frames: &Frames<'_, D>,
    bodies: &[NamedBody<D>],
    modes: &[Mode],
) -> Vec<String> {
    let axes = bodies.first().map_or(Space::default(), |named| named.body.space()).axes();
    let mut told: Vec<(String, Vec<String>)> = Vec::new();
    // Translations are told first.
    let (turning, sliding): (Vec<&Mode>, Vec<&Mode>) = modes.iter().partition(|mode| turns(mode));
    for mode in sliding.iter().chain(&turning) {
        let Some((&first, motion)) = mode.iter().next() else { continue };
        let subject = subject(frames, bodies, mode);
        let slides = sliding.iter().any(|other| other.contains_key(&first));
        let how = how(frames, axes, first, motion, !slides);
        match told.iter_mut().find(|(before, _)| *before == subject) {
            Some((_, motions)) => motions.push(how),
            None => told.push((subject, vec![how])),
        }
    }
    let left_out = told.len().saturating_sub(MOST_TOLD);
    told.truncate(MOST_TOLD);
    let mut clauses: Vec<String> =
        told.into_iter().map(|(subject, motions)| format!("{subject} {}", listed(&motions))).collect();
    if left_out > 0 {
        clauses.push(format!("{left_out} more parts"));
    }
    clauses
}

/// What moves in a mode.
fn subject<const D: usize>(frames: &Frames<'_, D>, bodies: &[NamedBody<D>], mode: &Mode) -> String {
    let mut moving: Vec<usize> = vec![0; bodies.len()];
    for &(body, points) in mode.keys().flat_map(|&part| &frames.parts.points[part]) {
        moving[body] += points;
    }
    let name = |body: usize| {
        let (name, all) = (&bodies[body].name, frames.parts.n_points[body]);
        if moving[body] == all {
            return format!("body `{name}`");
        }
        let part = mode.keys().find(|part| frames.parts.points[**part].iter().any(|it| it.0 == body));
        let centre = part
            .map_or(String::new(), |&part| format!(" around {}", place(frames, part, &frames.centre(part))));
        format!("a part of body `{name}` ({} of {all} points{centre})", moving[body])
    };
    let names: Vec<String> = (0..bodies.len()).filter(|&body| moving[body] > 0).map(name).collect();
    listed(&names)
}

/// A motion of a part in words; where a rotation takes place only if it is nowhere else as well.
fn how<const D: usize>(
    frames: &Frames<'_, D>,
    axes: [&str; 3],
    part: usize,
    motion: &Motion,
    is_fixed: bool,
) -> String {
    let Motion { rotation, translation } = *motion;
    let turns_about_axis = axes == Space::Axisymmetric.axes() && rotation == [0.0; 3] && translation[2] != 0.0;
    if turns_about_axis && translation[..2] == [0.0; 2] {
        return "about the axis".into();
    }
    if rotation == [0.0; 3] {
        return format!("along {}", direction(translation, axes));
    }
    let square: f64 = rotation.iter().map(|it| it * it).sum();
    let centre = frames.centre(part);
    let arm = cross(rotation, translation).map(|it| it / square);
    let pivot: Vector<D> = Vector::from_fn(|i, _| centre[i] + arm[i]);
    if D == 2 {
        let about =
            if is_fixed { format!(" about the point {}", place(frames, part, &pivot)) } else { String::new() };
        return format!("in rotation{about}");
    }
    let through =
        if is_fixed { format!(" through the point {}", place(frames, part, &pivot)) } else { String::new() };
    format!("in rotation about an axis along {}{through}", direction(rotation, axes))
}

/// The name of an axis, or the components of a direction of length 1.
fn direction(of: [f64; 3], axes: [&str; 3]) -> String {
    let length = of.iter().fold(0.0_f64, |sum, it| sum.hypot(*it));
    let unit = of.map(|it| it / length);
    match (0..3).find(|&i| unit[i].abs() > 1.0 - 1e-12) {
        Some(axis) => axes[axis].into(),
        None => bracketed(&unit, 1.0),
    }
}

/// A place at or near a part.
fn place<const D: usize>(frames: &Frames<'_, D>, part: usize, x: &Vector<D>) -> String {
    bracketed(x.as_slice(), frames.size(part).max(x.amax()))
}

/// Numbers in brackets; what is nothing against `size` is what rounding left of 0.
fn bracketed(numbers: &[f64], size: f64) -> String {
    let number = |it: &f64| if it.abs() < 1e-9 * size { "0".into() } else { six_digits(*it) };
    format!("({})", numbers.iter().map(number).collect::<Vec<String>>().join(", "))
}

fn listed(names: &[String]) -> String {
    match names {
        [all @ .., last] if !all.is_empty() => format!("{} and {last}", all.join(", ")),
        _ => names.concat(),
    }
}
