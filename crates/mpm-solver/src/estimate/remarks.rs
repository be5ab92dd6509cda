//! What in a model is probably not meant, though it can be run.

use super::driven;
use crate::connection::stencils;
use crate::model::{Model, NamedBody, Support};
use crate::ranks::Alone;
use crate::steps::stations;
use mpm_assembly::{Space, of_points, views};
use mpm_basis::ActiveNodes;
use mpm_grid::{LoadFraction, Mesh, Vector, six_digits};
use std::array::from_fn;
use std::collections::BTreeMap;

/// Bounds of what cells inside of a body, with points in all cells around, are filled to in all.
const INSIDE: [f64; 2] = [0.5, 1.5];

/// Bounds of what the cells of a body without such cells are filled to in all. Points fill a cell up to twice per
/// direction, where their domains are little smaller than the cell.
const ANY: [f64; 2] = [0.02, 4.0];

/// Points across a shear band at least.
const ACROSS: f64 = 6.0;

/// What in a model is probably not meant: the remarks of [`crate::estimate()`] that ask for a change. It connects the points once, and
/// runs nothing; nothing is said of a model that cannot begin to run.
pub fn doubts<const D: usize>(model: &Model<D>) -> Vec<String> {
    // A share of the points does not tell what all of them reach.
    if model.share.is_some() {
        return Vec::new();
    }
    let Ok(mesh) = model.motion.mesh_at(&model.layout, LoadFraction::START) else { return Vec::new() };
    let Ok(stencils) = stencils(model, &mesh, &Alone) else { return Vec::new() };
    of(model, &mesh, &ActiveNodes::of(&model.nodes, &stencils))
}

/// Sentences, the most surprising first.
pub(super) fn of<const D: usize>(model: &Model<D>, mesh: &Mesh<D>, active: &ActiveNodes<D>) -> Vec<String> {
    let mut remarks: Vec<String> = model.bodies.iter().flat_map(|named| fill(named, mesh)).collect();
    remarks.extend(model.supports.iter().filter(|support| touches_nothing(support, active)).map(|support| {
        format!("support `{}` touches no material: none of its nodes carries any", support.name)
    }));
    remarks.extend(driven::of(model, mesh, active));
    let bodies = model.bodies_by_name();
    remarks.extend(model.contributions.iter().flat_map(|named| named.contribution.remarks(mesh, &bodies)));
    remarks.extend(model.bodies.iter().filter_map(across_bands));
    remarks.extend(model.bodies.iter().filter_map(longer_than_body));
    if active.space().degrees().iter().all(|degree| *degree == 1) {
        remarks.extend(model.bodies.iter().filter_map(|named| one_a_cell(named, mesh)));
    }
    remarks.extend(jumps(model));
    remarks
}

/// What is as it should be, and good to know.
pub(super) fn good_to_know<const D: usize>(
    model: &Model<D>,
    mesh: &Mesh<D>,
    active: &ActiveNodes<D>,
) -> impl Iterator<Item = String> {
    shared(model, mesh, active).into_iter().chain(knots(model))
}

/// Points of a body that fill their cells more, or far less, than these hold.
fn fill<const D: usize>(named: &NamedBody<D>, mesh: &Mesh<D>) -> Option<String> {
    let mut cells: BTreeMap<[u32; D], (f64, Vector<D>)> = BTreeMap::new();
    for view in views(&*named.body) {
        let Ok(place) = mesh.locate(&view.position, 0.5) else { continue };
        let (filled, _) = cells.entry(place.cell).or_insert((0.0, view.position));
        *filled += view.reference_size;
    }
    let volume = |cell: &[u32; D]| mesh.piece(*cell, &Vector::repeat(-1.0), &Vector::repeat(1.0)).volume();
    let name = &named.name;
    let over = |(cell, (filled, _)): &(&[u32; D], &(f64, Vector<D>))| filled / volume(cell);
    let fullest = cells.iter().max_by(|a, b| over(a).total_cmp(&over(b)))?;
    let coordinates = named.body.space().coordinates::<D>();
    if over(&fullest) > f64::from(1 << coordinates) {
        let (cell, (filled, at)) = fullest;
        return Some(format!(
            "points of body `{name}` in the cell at {} have volume {}, the cell has {}: are their volumes in other units?",
            place(named.body.space(), at),
            six_digits(*filled),
            six_digits(volume(cell))
        ));
    }
    let is_inside = |cell: &[u32; D]| {
        (0..3_u32.pow(coordinates as u32)).all(|k| {
            let by = |d: usize| if d < coordinates { k / 3_u32.pow(d as u32) % 3 } else { 1 };
            let around = from_fn(|d| (cell[d] + by(d)).wrapping_sub(1));
            cells.contains_key(&around)
        })
    };
    let sum = |of: &dyn Fn(&[u32; D]) -> bool| {
        let chosen = cells.iter().filter(|(cell, _)| of(cell));
        chosen.fold((0.0, 0.0), |(filled, whole), (cell, (more, _))| (filled + more, whole + volume(cell)))
    };
    let inside = sum(&is_inside);
    let ((filled, whole), [least, most], which) =
        if inside.1 > 0.0 { (inside, INSIDE, "inside it") } else { (sum(&|_| true), ANY, "that hold them") };
    (!(least..=most).contains(&(filled / whole))).then(|| {
        format!(
            "points of body `{name}` have volume {} in the cells {which}, which have {}: are their volumes in other units?",
            six_digits(filled),
            six_digits(whole)
        )
    })
}

/// Points of a regularised body that are too large for the width of its shear bands.
fn across_bands<const D: usize>(named: &NamedBody<D>) -> Option<String> {
    let width = named.body.band_width()?;
    let largest = (0..named.body.n_points()).map(|p| named.body.extent(p).width).fold(0.0, f64::max);
    (largest * ACROSS > width).then(|| {
        format!(
            "shear bands of body `{}` are about {} wide, and its points up to {}: expected {ACROSS} points across a band",
            named.name,
            six_digits(width),
            six_digits(largest)
        )
    })
}

/// A regularised body in which the field is all but uniform, because its length is larger than the body.
fn longer_than_body<const D: usize>(named: &NamedBody<D>) -> Option<String> {
    let length = named.body.regularisation()?.length();
    let extents = (0..named.body.n_points()).map(|p| named.body.extent(p));
    let (mut low, mut high) = (Vector::<D>::repeat(f64::INFINITY), Vector::<D>::repeat(f64::NEG_INFINITY));
    for extent in extents {
        let half = Vector::repeat(0.5 * extent.width);
        (low, high) = (low.inf(&(extent.position - half)), high.sup(&(extent.position + half)));
    }
    let size = (high - low).max();
    (length > size).then(|| {
        format!(
            "the length of the nodal field of body `{}` is {}, and the body is about {} long: the field is all but uniform in it",
            named.name,
            six_digits(length),
            six_digits(size)
        )
    })
}

/// A body under stress with one point in most of its cells. Linear functions let such a cell take shapes whose gradient is zero at
/// its middle (hourglasses): nothing but its neighbours holds them, and stress makes them grow.
fn one_a_cell<const D: usize>(named: &NamedBody<D>, mesh: &Mesh<D>) -> Option<String> {
    let mut cells: BTreeMap<[u32; D], usize> = BTreeMap::new();
    let mut is_stressed = false;
    for (view, kirchhoff) in of_points(&*named.body, |p| (named.body.point(p), named.body.kirchhoff(p))) {
        is_stressed |= kirchhoff.norm() > 0.0;
        if let Ok(place) = mesh.locate(&view.position, 0.5) {
            *cells.entry(place.cell).or_insert(0) += 1;
        }
    }
    let single = cells.values().filter(|points| **points == 1).count();
    (is_stressed && 2 * single > cells.len()).then(|| {
        format!(
            "body `{}` begins under stress with one material point in most of its cells: nothing but their neighbours holds shapes of \
             such cells without strain at the point, and under stress they grow; two points per direction hold them",
            named.name
        )
    })
}

/// A position by the names of its coordinates.
pub(super) fn place<const D: usize>(space: Space, x: &Vector<D>) -> String {
    let told: Vec<String> =
        (0..space.coordinates::<D>()).map(|d| format!("{} = {}", space.axes()[d], six_digits(x[d]))).collect();
    told.join(", ")
}

fn touches_nothing<const D: usize>(support: &Support<D>, active: &ActiveNodes<D>) -> bool {
    !support.nodes.iter().any(|&node| active.number(node).is_some())
}

/// Pairs of supports that prescribe the same component of a node.
fn shared<const D: usize>(model: &Model<D>, mesh: &Mesh<D>, active: &ActiveNodes<D>) -> Vec<String> {
    let mut holders: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for (k, support) in model.supports.iter().enumerate() {
        for number in support.nodes.iter().filter_map(|&node| active.number(node)) {
            for i in (0..D).filter(|&i| support.components[i].is_some()) {
                holders.entry((number, i)).or_default().push(k);
            }
        }
    }
    // Of every pair: the nodes, once each, in their order.
    let mut pairs: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for ((number, _), holders) in &holders {
        for (k, first) in holders.iter().enumerate() {
            for second in holders[k + 1..].iter().filter(|&&second| act_together(model, *first, second)) {
                let nodes = pairs.entry((*first, *second)).or_default();
                if nodes.last() != Some(number) {
                    nodes.push(*number);
                }
            }
        }
    }
    let sentence = |((first, second), nodes): ((usize, usize), Vec<usize>)| {
        let [first, second] = [first, second].map(|k| &model.supports[k].name);
        let at = active.space().position(mesh, active.nodes()[nodes[0]]);
        let how_many = if nodes.len() == 1 { "a node".into() } else { format!("{} nodes", nodes.len()) };
        format!(
            "supports `{first}` and `{second}` share {how_many}, at {}: its force is in the reaction of each, and once \
             in `reaction/total`",
            place(model.space(), &at)
        )
    };
    pairs.into_iter().map(sentence).collect()
}

/// Whether two supports act in one stage.
fn act_together<const D: usize>(model: &Model<D>, first: usize, second: usize) -> bool {
    let both = |stage| [first, second].iter().all(|&k| model.supports[k].acts_in(stage));
    (0..model.stages.len() as u32).any(both)
}

/// Ramps of what is prescribed that do not begin at rest.
fn jumps<const D: usize>(model: &Model<D>) -> Vec<String> {
    let mut jumps = Vec::new();
    for (number, stage) in model.stages.iter().enumerate() {
        let mut jump = |who: String| {
            jumps.push(match number {
                0 => format!("{who} begins elsewhere than at rest: it jumps there in the first load step"),
                _ => format!(
                    "in stage `{}` {who} begins elsewhere than where the stage before has left it: it jumps there in the \
                     first load step",
                    stage.name
                ),
            });
        };
        let number = number as u32;
        for support in model.supports.iter().filter(|support| support.acts_in(number)) {
            if support.components.iter().flatten().any(|prescribed| prescribed.jumps_in(number)) {
                jump(format!("support `{}`", support.name));
            }
        }
        if model.motion.ramps().iter().any(|ramp| ramp.jumps_in(number)) {
            jump("the motion of the mesh".into());
        }
        for named in &model.contributions {
            if named.contribution.ramps().iter().any(|ramp| ramp.jumps_in(number)) {
                jump(format!("`{}`", named.name));
            }
        }
    }
    jumps
}

/// Knots of ramps at which no load step would end.
fn knots<const D: usize>(model: &Model<D>) -> Option<String> {
    let of = |stage| {
        let total = move |knot| f64::from(stage) + knot;
        stations(model, stage).knots().map(total).map(six_digits).collect::<Vec<String>>()
    };
    let between: Vec<String> = (0..model.stages.len() as u32).flat_map(of).collect();
    if between.is_empty() {
        return None;
    }
    let listed = match &between[..] {
        [few @ .., last] if between.len() < 6 && !few.is_empty() => format!("{} and {last}", few.join(", ")),
        [one] => one.clone(),
        _ => format!("{}, {}, … {}", between[0], between[1], between[between.len() - 1]),
    };
    Some(match model.follows_path() {
        false => format!("load steps end at knots of ramps, too: at load fraction {listed}"),
        true => format!("ramps have knots at load fraction {listed}; steps along the path pass over them"),
    })
}
