//! What contributions remember of points, on the way with the points.

use crate::key::{Key, Keys, read_keys, write_keys};
use crate::message::{Reader, Writer};
use crate::wire::Wire;
use mpm_assembly::{OfPoint, SavedByPoint};
use mpm_solver::{Model, StoredContribution};

/// How the contributions of a model remember points.
pub(crate) struct Memories {
    /// Of every contribution.
    by_point: Vec<Option<SavedByPoint>>,
}

/// What contributions remember of points, and what they remember besides.
pub(crate) struct Remembered {
    /// Of every contribution.
    common: Vec<Vec<f64>>,
    items: Vec<Item>,
}

/// What a contribution remembers of a point.
#[derive(Clone, Debug)]
struct Item {
    contribution: usize,
    body: usize,
    key: Key,
    numbers: Vec<f64>,
}

impl Memories {
    pub(crate) fn of_model<const D: usize>(model: &Model<D>) -> Self {
        Self { by_point: model.contributions.iter().map(|named| named.contribution.saved_by_point()).collect() }
    }

    /// Of what the contributions have saved, where the points have these keys.
    fn apart<'a>(&self, saved: impl Iterator<Item = &'a [f64]>, keys: &Keys) -> Remembered {
        let mut remembered = Remembered { common: Vec::new(), items: Vec::new() };
        for ((contribution, by_point), saved) in self.by_point.iter().enumerate().zip(saved) {
            let Some(by_point) = by_point else {
                remembered.common.push(Vec::new());
                continue;
            };
            let (common, of_points) = (by_point.apart)(saved);
            remembered.common.push(common);
            remembered.items.extend(of_points.into_iter().map(|OfPoint { body, point, numbers }| Item {
                contribution,
                body,
                key: keys[body][point],
                numbers,
            }));
        }
        remembered
    }

    /// What each contribution has saved together, of those of the points that have these keys; none where it is the same for
    /// all ranks.
    fn together(&self, mut remembered: Remembered, keys: &Keys) -> Vec<Option<Vec<f64>>> {
        remembered.items.sort_by_key(|it| (it.contribution, it.body, it.key));
        let mut of_points: Vec<Vec<OfPoint>> = vec![Vec::new(); self.by_point.len()];
        for Item { contribution, body, key, numbers } in remembered.items {
            if let Ok(point) = keys[body].binary_search(&key) {
                of_points[contribution].push(OfPoint { body, point, numbers });
            }
        }
        let all = self.by_point.iter().zip(remembered.common).zip(of_points);
        all.map(|((by_point, common), of)| Some((by_point.as_ref()?.together)(&common, &of))).collect()
    }

    /// What the contributions of a model remember, whose points have these keys.
    pub(crate) fn of<const D: usize>(&self, model: &Model<D>, keys: &Keys) -> Remembered {
        let saved = |(by_point, k): (&Option<SavedByPoint>, usize)| match by_point {
            Some(_) => model.contributions[k].contribution.save(),
            None => Vec::new(),
        };
        let saved: Vec<Vec<f64>> = self.by_point.iter().zip(0..).map(saved).collect();
        self.apart(saved.iter().map(Vec::as_slice), keys)
    }

    fn put<const D: usize>(&self, model: &mut Model<D>, remembered: Remembered, keys: &Keys) {
        for (named, numbers) in model.contributions.iter_mut().zip(self.together(remembered, keys)) {
            if let Some(numbers) = numbers {
                named.contribution.restore(&numbers).expect("what contributions remember of points is theirs");
            }
        }
    }

    /// Keeps what belongs to the points of these keys, which are the numbers of the points.
    pub(crate) fn keep<const D: usize>(&self, model: &mut Model<D>, keys: &Keys, all: &Keys) {
        let remembered = self.of(model, all);
        self.put(model, remembered, keys);
    }

    /// Takes what was remembered where points were to the ranks that have them now, by these keys. `owners` are those of the
    /// points that were here before, whose keys were `before`.
    pub(crate) fn migrate<const D: usize>(
        &self,
        model: &mut Model<D>,
        remembered: Remembered,
        (before, owners): (&Keys, &[Vec<usize>]),
        (keys, wire): (&Keys, &impl Wire),
    ) {
        if self.by_point.iter().all(Option::is_none) {
            return;
        }
        let mut out: Vec<Writer> = vec![Writer::default(); wire.size()];
        for item in &remembered.items {
            let place = before[item.body].binary_search(&item.key).expect("points were here");
            item.write(&mut out[owners[item.body][place]]);
        }
        let out = out.into_iter().map(Writer::finish).enumerate().filter(|it| !it.1.is_empty());
        let incoming = wire.exchange(&out.collect::<Vec<_>>());
        let items = incoming.iter().flat_map(|(_, bytes)| items(bytes)).collect();
        self.put(model, Remembered { items, ..remembered }, keys);
    }

    /// What contributions have saved of the points of all ranks, on rank 0, where these have the keys `all`; on the others of
    /// their own.
    pub(crate) fn join(
        &self,
        stored: &mut [StoredContribution],
        (keys, all): (&Keys, &Keys),
        wire: &impl Wire,
    ) {
        if self.by_point.iter().all(Option::is_none) {
            return;
        }
        let own = self.apart(stored.iter().map(|it| it.numbers.as_slice()), keys);
        let mut out = Writer::default();
        own.items.iter().for_each(|item| item.write(&mut out));
        let incoming = wire.exchange(&[(0, out.finish())]);
        let items = match wire.rank() {
            0 => incoming.iter().flat_map(|(_, bytes)| items(bytes)).collect(),
            _ => own.items,
        };
        for (stored, numbers) in stored.iter_mut().zip(self.together(Remembered { items, ..own }, all)) {
            if let Some(numbers) = numbers {
                stored.numbers = numbers;
            }
        }
    }
}

impl Item {
    fn write(&self, to: &mut Writer) {
        to.count(self.contribution as u64);
        to.count(self.body as u64);
        write_keys(&[self.key], to);
        to.numbers(&self.numbers);
    }
}

fn items(bytes: &[u8]) -> Vec<Item> {
    let (mut from, mut items) = (Reader::new(bytes), Vec::new());
    while !from.is_at_end() {
        let (contribution, body, key) = (from.index(), from.index(), read_keys(&mut from)[0]);
        items.push(Item { contribution, body, key, numbers: from.numbers() });
    }
    items
}
