//! What corners remember of the parts of a tool from one load step to the next.

use mpm_contact::{CornerState, Mode, Pose};
use mpm_grid::Vector;

/// Which corner of which point meets which part of the tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    pub body: u32,
    pub point: u32,
    pub part: u32,
    pub corner: u32,
}

impl Key {
    /// Whether both are of one point and one part.
    pub fn is_beside(&self, other: &Self) -> bool {
        (self.body, self.point, self.part) == (other.body, other.point, other.part)
    }
}

/// What a corner remembers of a place of a part's surface. Of a point that has touched a part all corners are kept, so
/// that its corners can be told from those that it had before, where its domain was shortened or split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch<const D: usize> {
    pub key: Key,
    /// Where the corner was at the end of the step `[L]`.
    pub position: Vector<D>,
    /// Signed distance to the surface there `[L]`.
    pub distance: f64,
    /// None where the corner has touched nothing.
    pub state: Option<CornerState<D>>,
}

/// All that is remembered: ascending in the key, and of one corner in the order in which places were found.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Memory<const D: usize> {
    /// Whether a step has been committed: what was inside the tool before that was there from the start.
    pub has_begun: bool,
    pub touches: Vec<Touch<D>>,
    /// The points that have touched the tool so far, ascending; only results want them.
    pub points: Vec<TouchedPoint<D>>,
}

/// What a point that has touched the tool tells in results.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TouchedPoint<const D: usize> {
    /// Numbers of the body and of its point.
    pub place: [u32; 2],
    /// Force of the tool on it in the last step `[F]`.
    pub force: Vector<D>,
    /// How far its corners have slipped so far `[L]`.
    pub slip: f64,
}

/// A corner that is looked for after its point has been carried on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sought<'a, const D: usize> {
    pub key: Key,
    pub position: Vector<D>,
    pub width: f64,
    /// Signed distance to the nearest place of the part `[L]`.
    pub distance: f64,
    /// The tool's pose where the step begins.
    pub pose: &'a Pose<D>,
}

/// What a corner remembers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Recalled<const D: usize> {
    /// One state for each place of the part's surface that it has touched.
    pub states: Vec<CornerState<D>>,
    /// Where it stood when they were made `[L]`.
    pub left: Vector<D>,
}

/// Part of a domain's width by which a corner may have moved and still counts as the same: no more than that lies between
/// a corner that is carried by the nodes and one of a domain that follows F. Domains that were shortened or split
/// have other corners.
const SAME: f64 = 0.25;

impl<const D: usize> Memory<D> {
    /// What points tell after a step in which they have told `of_step`: forces are those of the step, slips are added up.
    pub fn points_after(&self, of_step: Vec<TouchedPoint<D>>) -> Vec<TouchedPoint<D>> {
        let before = self.points.iter().map(|it| TouchedPoint { force: Vector::zeros(), ..*it });
        let mut points: Vec<TouchedPoint<D>> = before.chain(of_step).collect();
        points.sort_by_key(|it| it.place);
        points.dedup_by(|next, it| {
            let is_same = next.place == it.place;
            if is_same {
                (it.force, it.slip) = (it.force + next.force, it.slip + next.slip);
            }
            is_same
        });
        points
    }

    /// What the corners of a point remember; `place` has the numbers of its body and its own.
    pub fn touches_of(&self, place: [u32; 2]) -> &[Touch<D>] {
        let of = |touch: &Touch<D>| [touch.key.body, touch.key.point];
        let start = self.touches.partition_point(|touch| of(touch) < place);
        let end = start + self.touches[start..].partition_point(|touch| of(touch) == place);
        &self.touches[start..end]
    }

    /// What the corners of a point remember of a part; only points that have touched are remembered.
    fn of_point(&self, body: u32, point: u32, part: u32) -> &[Touch<D>] {
        let place = |touch: &Touch<D>| (touch.key.body, touch.key.point, touch.key.part);
        let start = self.touches.partition_point(|touch| place(touch) < (body, point, part));
        let end = start + self.touches[start..].partition_point(|touch| place(touch) == (body, point, part));
        &self.touches[start..end]
    }

    /// Whether a point has touched a part of the tool in the last step.
    pub fn has_touched(&self, body: usize, point: usize, part: usize) -> bool {
        !self.of_point(body as u32, point as u32, part as u32).is_empty()
    }

    /// What the corner remembers. Where its domain was
    /// shortened, reshaped or split, the nearest corner of before hands on its elastic slip and its multiplier.
    pub fn recall(&self, sought: &Sought<'_, D>) -> Recalled<D> {
        let Key { body, point, part, .. } = sought.key;
        let touches = self.of_point(body, point, part);
        let offset = |touch: &Touch<D>| (touch.position - sought.position).norm();
        let own = touches.iter().filter(|touch| touch.key.corner == sought.key.corner);
        let same = own.clone().find(|touch| offset(touch) <= SAME * sought.width);
        if let Some(&Touch { position: left, .. }) = same {
            return Recalled { states: own.filter_map(|touch| touch.state).collect(), left };
        }
        let left = sought.position;
        let Some(nearest) = touches.iter().min_by(|a, b| offset(a).total_cmp(&offset(b))) else {
            return Recalled { states: Vec::new(), left };
        };
        let of_nearest = touches.iter().filter(|touch| touch.key.corner == nearest.key.corner);
        let states = of_nearest.filter_map(|touch| Some(handed_on(touch, &touch.state?, sought))).collect();
        Recalled { states, left }
    }

    /// Hands what points remember to the parts that they were split into.
    pub fn divide(&mut self, body: u32, parts: &[(usize, f64)]) {
        let mut divided = Vec::with_capacity(self.touches.len());
        let (before, rest) = self.touches.split_at(self.touches.partition_point(|it| it.key.body < body));
        let (own, after) = rest.split_at(rest.partition_point(|it| it.key.body == body));
        divided.extend_from_slice(before);
        for (point, &(parent, _)) in parts.iter().enumerate() {
            let start = own.partition_point(|it| (it.key.point as usize) < parent);
            for touch in own[start..].iter().take_while(|it| it.key.point as usize == parent) {
                divided.push(Touch { key: Key { point: point as u32, ..touch.key }, ..*touch });
            }
        }
        divided.extend_from_slice(after);
        self.touches = divided;
        self.divide_points(body, parts);
    }

    /// Parts of a point share its force, and have slipped as far as it has.
    fn divide_points(&mut self, body: u32, parts: &[(usize, f64)]) {
        let mut divided = self.points.clone();
        divided.retain(|it| it.place[0] != body);
        for (part, &(parent, share)) in parts.iter().enumerate() {
            if let Ok(at) = self.points.binary_search_by_key(&[body, parent as u32], |it| it.place) {
                let TouchedPoint { force, slip, .. } = self.points[at];
                divided.push(TouchedPoint { place: [body, part as u32], force: force * share, slip });
            }
        }
        divided.sort_by_key(|it| it.place);
        self.points = divided;
    }
}

/// The state of a corner that takes the place of another.
fn handed_on<const D: usize>(
    touch: &Touch<D>,
    state: &CornerState<D>,
    sought: &Sought<'_, D>,
) -> CornerState<D> {
    let moved = sought.position - touch.position;
    CornerState {
        anchor: state.anchor + sought.pose.turn_back(&moved),
        offset: match state.held {
            true => state.offset + (sought.distance - touch.distance),
            false if sought.distance < touch.distance => sought.distance.min(0.0),
            false => state.offset,
        },
        ..*state
    }
}

/// The mode of a corner that has touched nothing, in a file.
const UNTOUCHED: f64 = 3.0;

/// Numbers of a touch besides its vectors.
const SCALARS: usize = 9;

impl<const D: usize> Touch<D> {
    /// Numbers of a touch in a file.
    pub const NUMBERS: usize = SCALARS + 3 * D;

    pub fn save(&self, to: &mut Vec<f64>) {
        let Key { body, point, part, corner } = self.key;
        to.extend([body, point, part, corner].map(f64::from));
        to.extend(self.position.iter());
        let nothing = CornerState {
            anchor: Vector::zeros(),
            normal: Vector::zeros(),
            multiplier: 0.0,
            offset: 0.0,
            mode: Mode::Open,
            held: false,
        };
        let CornerState { anchor, normal, multiplier, offset, mode, held } = self.state.unwrap_or(nothing);
        let mode = match mode {
            _ if self.state.is_none() => UNTOUCHED,
            Mode::Open => 0.0,
            Mode::Stuck => 1.0,
            Mode::Slipping => 2.0,
        };
        to.extend([self.distance, multiplier, offset, mode, f64::from(u8::from(held))]);
        to.extend(anchor.iter().chain(normal.iter()));
    }

    pub fn restore(from: &[f64]) -> Result<Self, String> {
        let at = |k: usize| count(from[k]);
        let key = Key { body: at(0)?, point: at(1)?, part: at(2)?, corner: at(3)? };
        let vector = |at: usize| Vector::<D>::from_column_slice(&from[at..at + D]);
        let [distance, multiplier, offset, mode, held] = std::array::from_fn(|k| from[4 + D + k]);
        let mode = match mode {
            0.0 => Some(Mode::Open),
            1.0 => Some(Mode::Stuck),
            2.0 => Some(Mode::Slipping),
            UNTOUCHED => None,
            other => return Err(format!("has a corner of mode {other}, expected 0, 1, 2 or 3")),
        };
        if held != 0.0 && held != 1.0 {
            return Err(format!("has a corner that is held by {held}, expected 0 or 1"));
        }
        let (anchor, normal) = (vector(SCALARS + D), vector(SCALARS + 2 * D));
        let held = held == 1.0;
        let state = mode.map(|mode| CornerState { anchor, normal, multiplier, offset, mode, held });
        Ok(Self { key, position: vector(4), distance, state })
    }
}

/// A number of a body, a point, a part or a corner.
fn count(number: f64) -> Result<u32, String> {
    let is_count = number >= 0.0 && number.fract() == 0.0 && number <= f64::from(u32::MAX);
    if is_count { Ok(number as u32) } else { Err(format!("names a corner by {number}")) }
}

impl<const D: usize> TouchedPoint<D> {
    /// Numbers of a point in a file.
    pub const NUMBERS: usize = 3 + D;

    pub fn save(&self, to: &mut Vec<f64>) {
        to.extend(self.place.map(f64::from));
        to.extend(self.force.iter());
        to.push(self.slip);
    }

    pub fn restore(from: &[f64]) -> Result<Self, String> {
        let force = Vector::from_column_slice(&from[2..2 + D]);
        Ok(Self { place: [count(from[0])?, count(from[1])?], force, slip: from[2 + D] })
    }
}

impl<const D: usize> Memory<D> {
    /// Appends all as plain numbers: nothing before the first step, then the number of points with one added, the points,
    /// and all touches.
    pub fn save(&self, to: &mut Vec<f64>) {
        if self.has_begun {
            to.push((self.points.len() + 1) as f64);
            self.points.iter().for_each(|point| point.save(to));
            self.touches.iter().for_each(|touch| touch.save(to));
        }
    }

    /// What was saved.
    ///
    /// # Errors
    /// What in the numbers no run has saved.
    pub fn restore(saved: &[f64]) -> Result<Self, String> {
        let Some((first, numbers)) = saved.split_first() else { return Ok(Self::default()) };
        if let Some(number) = saved.iter().find(|number| !number.is_finite()) {
            return Err(format!("has the number {number}, expected finite ones"));
        }
        let (of_point, width) = (TouchedPoint::<D>::NUMBERS, Touch::<D>::NUMBERS);
        let of_points = count(*first)?.checked_sub(1).map(|n| n as usize * of_point);
        let Some((points, touches)) = of_points
            .and_then(|n| numbers.split_at_checked(n))
            .filter(|(_, touches)| touches.len().is_multiple_of(width))
        else {
            let n = saved.len();
            return Err(format!(
                "has {n} numbers, expected {of_point} for each point and {width} for each corner"
            ));
        };
        let points: Vec<TouchedPoint<D>> =
            points.chunks_exact(of_point).map(TouchedPoint::restore).collect::<Result<_, _>>()?;
        let touches: Vec<Touch<D>> =
            touches.chunks_exact(width).map(Touch::restore).collect::<Result<_, _>>()?;
        if !touches.is_sorted_by_key(|touch| touch.key) || !points.is_sorted_by_key(|point| point.place) {
            return Err("has corners out of their order".into());
        }
        Ok(Self { has_begun: true, touches, points })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(point: u32, corner: u32, at: [f64; 2]) -> Touch<2> {
        let position = Vector::<2>::new(at[0], at[1]);
        let state = CornerState {
            anchor: position - Vector::<2>::new(0.01, 0.0),
            normal: Vector::<2>::new(0.0, 1.0),
            multiplier: 2.0,
            offset: -0.001,
            mode: Mode::Stuck,
            held: false,
        };
        Touch { key: Key { body: 0, point, part: 0, corner }, position, distance: -0.002, state: Some(state) }
    }

    #[test]
    fn what_was_saved_is_restored() {
        let open = Touch { state: None, ..touch(1, 4, [1.0, 1.0]) };
        let touches = vec![touch(1, 0, [0.0, 0.0]), touch(1, 3, [1.0, 0.0]), open, touch(4, 2, [2.0, 0.5])];
        let points = vec![told(1, 0.5, 0.1), told(4, 0.0, 0.2)];
        let memory = Memory { has_begun: true, touches, points };
        let mut wrong = Vec::new();
        memory.save(&mut wrong);
        assert_eq!(Memory::restore(&wrong).unwrap(), memory);
        assert!(Memory::<2>::restore(&wrong[1..]).is_err());
        assert_eq!(Memory::<2>::restore(&[]).unwrap(), Memory::default());
        wrong[2] = 7.0;
        assert!(Memory::<2>::restore(&wrong).unwrap_err().contains("order"));
        wrong[0] = 1e6;
        assert!(Memory::<2>::restore(&wrong).unwrap_err().contains("expected 5 for each point"));
        (wrong[0], wrong[2]) = (3.0, 0.5);
        assert!(Memory::<2>::restore(&wrong).unwrap_err().contains("0.5"));
        assert!(Memory::<2>::restore(&[1.0, f64::NAN]).is_err());
    }

    #[test]
    fn a_corner_that_has_touched_nothing_remembers_nothing() {
        let open = Touch { state: None, ..touch(1, 2, [0.0, 1.0]) };
        let touches = vec![touch(1, 0, [0.0, 0.0]), open];
        let memory = Memory { has_begun: true, touches, points: Vec::new() };
        let (key, position, pose) = (open.key, open.position, Pose::identity());
        let sought = Sought { key, position, width: 0.5, distance: 0.3, pose: &pose };
        assert_eq!(memory.recall(&sought).states, []);
    }

    fn told(point: u32, force: f64, slip: f64) -> TouchedPoint<2> {
        TouchedPoint { place: [0, point], force: Vector::<2>::new(force, 0.0), slip }
    }

    #[test]
    fn slips_add_up_and_go_with_the_points() {
        let mut memory = Memory { points: vec![told(1, 9.0, 0.1), told(4, 9.0, 0.2)], ..Memory::default() };
        memory.points = memory.points_after(vec![told(0, 1.0, 0.0), told(4, 2.0, 0.3), told(7, 3.0, 0.4)]);
        assert_eq!(memory.points, [told(0, 1.0, 0.0), told(1, 0.0, 0.1), told(4, 2.0, 0.5), told(7, 3.0, 0.4)]);
        memory.divide(0, &[(0, 1.0), (1, 1.0), (4, 0.25), (4, 0.75)]);
        assert_eq!(memory.points, [told(0, 1.0, 0.0), told(1, 0.0, 0.1), told(2, 0.5, 0.5), told(3, 1.5, 0.5)]);
        let other = memory.clone();
        memory.divide(1, &[(4, 1.0)]);
        assert_eq!(memory, other);
    }

    #[test]
    fn corners_of_a_split_domain_take_the_state_of_the_nearest_before() {
        let touches = vec![touch(1, 0, [0.0, 0.0]), touch(1, 1, [1.0, 0.0])];
        let mut memory = Memory { has_begun: true, touches, points: Vec::new() };
        memory.divide(0, &[(0, 1.0), (1, 0.5), (1, 0.5), (2, 1.0)]);
        let points: Vec<u32> = memory.touches.iter().map(|touch| touch.key.point).collect();
        assert_eq!(points, [1, 1, 2, 2]);
        let pose = Pose::identity();
        let sought = |point, corner, x, distance| Sought {
            key: Key { body: 0, point, part: 0, corner },
            position: Vector::<2>::new(x, 0.0),
            width: 0.5,
            distance,
            pose: &pose,
        };
        // The first half keeps its first corner; its second is new, deeper, and nearer to the second of before.
        let own = memory.recall(&sought(1, 0, 0.0, -0.002));
        assert_eq!((own.left, own.states), (Vector::zeros(), vec![touch(1, 0, [0.0, 0.0]).state.unwrap()]));
        let [middle] = memory.recall(&sought(1, 1, 0.6, -0.003)).states[..] else { panic!("one state") };
        assert_eq!(middle.multiplier, 2.0);
        assert_eq!(middle.offset, -0.003);
        assert!((middle.anchor - Vector::<2>::new(0.59, 0.0)).norm() < 1e-15);
        assert_eq!(memory.recall(&sought(0, 0, 0.0, 0.0)).states, []);
    }
}
