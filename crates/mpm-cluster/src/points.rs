//! The points of a rank: what they are called, who else has some, and how they get there.

use crate::key::{Key, Keys, read_keys, write_keys};
use crate::memories::Memories;
use crate::message::{Reader, Writer};
use crate::wire::Wire;
use mpm_assembly::{Body, StoredColumn, StoredPoints};
use mpm_solver::observe::Field;
use mpm_solver::{Model, Share, Side};

/// What names points in a model: the same on all ranks, whichever of the points they have.
pub(crate) struct Named<const D: usize> {
    /// Of every load on points, with its body.
    shares: Vec<(usize, Vec<(Key, Share<D>)>)>,
    sides: Vec<Vec<(Key, Side<D>)>>,
    probes: Vec<Vec<Key>>,
}

impl<const D: usize> Named<D> {
    /// Of a whole model.
    pub(crate) fn of(model: &Model<D>) -> Self {
        let key = |point: usize| Key { number: point as u64, ..Key::default() };
        let shares = model.loads.point_loads.iter().map(|load| (load.body, &load.shares));
        let sides = model.loads.side_loads.iter().map(|load| &load.sides);
        Self {
            shares: shares
                .map(|(body, of)| (body, of.iter().map(|share| (key(share.point), *share)).collect()))
                .collect(),
            sides: sides.map(|of| of.iter().map(|side| (key(side.point), *side)).collect()).collect(),
            probes: model.probes.iter().map(|it| it.points.iter().map(|&p| key(p)).collect()).collect(),
        }
    }

    /// Names those of the points that a rank has by their places there.
    pub(crate) fn write(&self, model: &mut Model<D>, keys: &Keys) {
        let place = |body: usize, key: &Key| keys[body].binary_search(key).ok();
        for (load, shares) in model.loads.point_loads.iter_mut().zip(self.shares(keys)) {
            load.shares = shares;
        }
        for (load, sides) in model.loads.side_loads.iter_mut().zip(&self.sides) {
            let here = sides.iter().filter_map(|(key, side)| Some((place(load.body, key)?, side)));
            load.sides = here.map(|(point, side)| Side { point, ..*side }).collect();
        }
        for (probe, points) in model.probes.iter_mut().zip(&self.probes) {
            probe.points = points.iter().filter_map(|key| place(probe.body, key)).collect();
        }
    }

    /// The loads' shares by the places that points of the given keys have.
    pub(crate) fn shares(&self, keys: &Keys) -> Vec<Vec<Share<D>>> {
        let of_load = |(body, shares): &(usize, Vec<(Key, Share<D>)>)| {
            let here =
                shares.iter().filter_map(|(key, share)| Some((keys[*body].binary_search(key).ok()?, share)));
            here.map(|(point, share)| Share { point, ..*share }).collect()
        };
        self.shares.iter().map(of_load).collect()
    }
}

/// What a rank knows of points.
pub(crate) struct Points<const D: usize> {
    pub(crate) keys: Keys,
    pub(crate) named: Named<D>,
    /// All fields that points have.
    pub(crate) fields: Vec<Field>,
    /// What contributions remember of them.
    pub(crate) memories: Memories,
}

impl<const D: usize> Points<D> {
    /// None yet, with the fields that they will have.
    pub(crate) fn of(model: &Model<D>, fields: Vec<Field>) -> Self {
        let memories = Memories::of_model(model);
        Self { keys: Vec::new(), named: Named::of(model), fields, memories }
    }

    /// The loads' shares among points of these keys.
    pub(crate) fn shares(&self, keys: &Keys) -> Vec<Vec<Share<D>>> {
        self.named.shares(keys)
    }
}

/// A point that was split, and the shares of its parts.
struct Split {
    key: Key,
    shares: Vec<f64>,
}

impl<const D: usize> Points<D> {
    /// Gives the parts of points that were split on any rank their keys, and their shares of what names their point.
    /// `parts` are those of this rank; empty where none was split.
    pub(crate) fn split(&mut self, body: usize, parts: &[(usize, f64)], wire: &impl Wire) {
        let mut to = Writer::default();
        if !parts.is_empty() {
            let mut keys = Vec::with_capacity(parts.len());
            for of_point in parts.chunk_by(|a, b| a.0 == b.0) {
                let key = self.keys[body][of_point[0].0];
                if of_point.len() == 1 {
                    keys.push(key);
                    continue;
                }
                keys.extend(key.parts(of_point.len()));
                write_keys(&[key], &mut to);
                to.numbers(&of_point.iter().map(|part| part.1).collect::<Vec<_>>());
            }
            self.keys[body] = keys;
        }
        let own = to.finish();
        let out: Vec<(usize, Vec<u8>)> = match own.is_empty() {
            true => Vec::new(),
            false => (0..wire.size()).map(|rank| (rank, own.clone())).collect(),
        };
        let mut splits = Vec::new();
        for (_, bytes) in wire.exchange(&out) {
            let mut from = Reader::new(&bytes);
            while !from.is_at_end() {
                let key = read_keys(&mut from)[0];
                splits.push(Split { key, shares: from.numbers() });
            }
        }
        splits.sort_by_key(|it| it.key);
        self.named.divide(body, &splits);
    }
}

impl<const D: usize> Named<D> {
    /// Every part of a point carries its share of the point's.
    fn divide(&mut self, body: usize, splits: &[Split]) {
        let of = |key: &Key| splits.binary_search_by_key(key, |it| it.key).ok().map(|at| &splits[at]);
        for (_, shares) in self.shares.iter_mut().filter(|it| it.0 == body) {
            let divided = std::mem::take(shares).into_iter().flat_map(|(key, share)| match of(&key) {
                None => vec![(key, share)],
                Some(split) => {
                    let parts = key.parts(split.shares.len()).into_iter().zip(&split.shares);
                    parts.map(|(key, part)| (key, Share { part: share.part * part, ..share })).collect()
                }
            });
            *shares = divided.collect();
        }
    }
}

/// Rows of a body's stored points with their keys.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    keys: Vec<Key>,
    points: StoredPoints,
}

impl Rows {
    /// Stored points with their keys.
    pub(crate) fn new(keys: Vec<Key>, points: StoredPoints) -> Self {
        Self { keys, points }
    }

    /// The present points of a body.
    pub(crate) fn of<const D: usize>(body: &dyn Body<D>, keys: &[Key]) -> Self {
        Self { keys: keys.to_vec(), points: body.store() }
    }

    /// No points, in the same columns.
    fn empty(&self) -> Self {
        let columns = self.points.columns.iter();
        let columns = columns.map(|it| StoredColumn { name: it.name, width: it.width, values: Vec::new() });
        Self { keys: Vec::new(), points: StoredPoints { points: 0, columns: columns.collect() } }
    }

    fn push(&mut self, from: &Self, row: usize) {
        self.keys.push(from.keys[row]);
        self.points.points += 1;
        for (to, from) in self.points.columns.iter_mut().zip(&from.points.columns) {
            to.values.extend(&from.values[row * from.width..(row + 1) * from.width]);
        }
    }

    /// One body of `Rows` for each of so many ranks, to which `owner` sends the rows.
    fn dealt(&self, ranks: usize, owner: &[usize]) -> Vec<Self> {
        let mut dealt = vec![self.empty(); ranks];
        owner.iter().enumerate().for_each(|(row, &rank)| dealt[rank].push(self, row));
        dealt
    }

    fn write(&self, to: &mut Writer) {
        write_keys(&self.keys, to);
        self.points.columns.iter().for_each(|column| to.numbers(&column.values));
    }

    /// Rows in the columns of `self`, as [`Self::write`] has written them.
    fn read(&self, from: &mut Reader<'_>) -> Self {
        let mut rows = self.empty();
        rows.keys = read_keys(from);
        rows.points.points = rows.keys.len();
        rows.points.columns.iter_mut().for_each(|column| column.values = from.numbers());
        rows
    }

    /// All rows, in the order of their keys.
    pub(crate) fn joined(parts: &[Self]) -> Self {
        let mut order: Vec<(Key, usize, usize)> = Vec::new();
        for (k, part) in parts.iter().enumerate() {
            order.extend(part.keys.iter().enumerate().map(|(row, &key)| (key, k, row)));
        }
        order.sort_unstable();
        let mut joined = parts[0].empty();
        order.iter().for_each(|&(_, part, row)| joined.push(&parts[part], row));
        joined
    }

    /// Stored points, and their keys.
    pub(crate) fn into_parts(self) -> (StoredPoints, Vec<Key>) {
        (self.points, self.keys)
    }

    /// The rows of all ranks on rank 0, in the order of their keys; on the others their own.
    pub(crate) fn on_rank_zero(bodies: Vec<Self>, wire: &impl Wire) -> Vec<Self> {
        let mut out = Writer::default();
        bodies.iter().for_each(|rows| rows.write(&mut out));
        let incoming = wire.exchange(&[(0, out.finish())]);
        if incoming.is_empty() {
            return bodies;
        }
        let mut readers: Vec<Reader<'_>> = incoming.iter().map(|(_, bytes)| Reader::new(bytes)).collect();
        let of_body = |rows: &Self| {
            let parts: Vec<Self> = readers.iter_mut().map(|reader| rows.read(reader)).collect();
            Self::joined(&parts)
        };
        bodies.iter().map(of_body).collect()
    }
}

/// Keeps of every body the points that `owner` gives to this rank; every rank has all points.
pub(crate) fn keep<const D: usize>(model: &mut Model<D>, owner: &[Vec<usize>], me: usize) -> Keys {
    let mut keys = Vec::new();
    for (named, owner) in model.bodies.iter_mut().zip(owner) {
        let rows = Rows::of(&*named.body, &Key::first(owner.len()));
        let mut kept = rows.empty();
        (0..owner.len()).filter(|&p| owner[p] == me).for_each(|p| kept.push(&rows, p));
        keys.push(restored(&mut *named.body, kept));
    }
    keys
}

/// Takes every point to the rank that `owner` says; each rank has those with its keys.
pub(crate) fn migrate<const D: usize>(
    model: &mut Model<D>,
    keys: &mut Keys,
    owner: &[Vec<usize>],
    wire: &impl Wire,
) {
    let (me, size) = (wire.rank(), wire.size());
    let mut dealt: Vec<Vec<Rows>> = Vec::new();
    for ((named, keys), owner) in model.bodies.iter().zip(&*keys).zip(owner) {
        dealt.push(Rows::of(&*named.body, keys).dealt(size, owner));
    }
    let leaves = |rank: &usize| *rank != me && owner.iter().flatten().any(|owner| owner == rank);
    let out = (0..size).filter(leaves).map(|rank| {
        let mut writer = Writer::default();
        dealt.iter().for_each(|of_body| of_body[rank].write(&mut writer));
        (rank, writer.finish())
    });
    let incoming = wire.exchange(&out.collect::<Vec<_>>());
    let mut readers: Vec<Reader<'_>> = incoming.iter().map(|(_, bytes)| Reader::new(bytes)).collect();
    for ((named, keys), of_body) in model.bodies.iter_mut().zip(keys).zip(&dealt) {
        let mut parts = vec![of_body[me].clone()];
        parts.extend(readers.iter_mut().map(|reader| of_body[me].read(reader)));
        if parts.len() > 1 || of_body[me].keys.len() < keys.len() {
            *keys = restored(&mut *named.body, Rows::joined(&parts));
        }
    }
}

fn restored<const D: usize>(body: &mut dyn Body<D>, rows: Rows) -> Vec<Key> {
    body.restore(&rows.points).expect("rows of a body are rows of the same body on another rank");
    rows.keys
}
