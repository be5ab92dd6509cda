//! What a tool saves, shared out with the points.

use super::loaded::Standing;
use super::memory::{Key, Memory, Touch, TouchedPoint};
use crate::sharing::{OfPoint, SavedByPoint};

/// Of a tool in so many dimensions.
pub(super) fn saved_by_point<const D: usize>() -> SavedByPoint {
    SavedByPoint { apart: apart::<D>, together: together::<D> }
}

/// What is the same for all is where the tool stands, and behind it one number more once a step has been committed. Of a point
/// the first number says whether it tells anything in results, which follows then, and behind that stand its corners.
fn apart<const D: usize>(saved: &[f64]) -> (Vec<f64>, Vec<OfPoint>) {
    let (standing, memory) = saved.split_at(Standing::<D>::NUMBERS);
    let memory = Memory::<D>::restore(memory).expect("what a tool has saved it restores");
    let mut common = standing.to_vec();
    common.extend(memory.has_begun.then_some(1.0));
    let mut places: Vec<[u32; 2]> = memory.points.iter().map(|it| it.place).collect();
    places.extend(memory.touches.iter().map(|it| [it.key.body, it.key.point]));
    places.sort_unstable();
    places.dedup();
    let of_point = |place: [u32; 2]| {
        let told = memory.points.binary_search_by_key(&place, |it| it.place).ok();
        let mut numbers = vec![f64::from(u8::from(told.is_some()))];
        told.iter().for_each(|&at| memory.points[at].save(&mut numbers));
        memory.touches_of(place).iter().for_each(|touch| touch.save(&mut numbers));
        OfPoint { body: place[0] as usize, point: place[1] as usize, numbers }
    };
    (common, places.into_iter().map(of_point).collect())
}

fn together<const D: usize>(common: &[f64], of_points: &[OfPoint]) -> Vec<f64> {
    let (standing, begun) = common.split_at(Standing::<D>::NUMBERS);
    let mut memory = Memory::<D> { has_begun: !begun.is_empty(), ..Memory::default() };
    for OfPoint { body, point, numbers } in of_points {
        let place = [*body as u32, *point as u32];
        let expected = "what a tool has saved it restores";
        let told = if numbers[0] > 0.0 { TouchedPoint::<D>::NUMBERS } else { 0 };
        let (told, touches) = numbers[1..].split_at(told);
        if !told.is_empty() {
            memory.points.push(TouchedPoint { place, ..TouchedPoint::restore(told).expect(expected) });
        }
        for touch in touches.chunks_exact(Touch::<D>::NUMBERS) {
            let touch = Touch::restore(touch).expect(expected);
            memory.touches.push(Touch { key: Key { body: place[0], point: place[1], ..touch.key }, ..touch });
        }
    }
    let mut numbers = standing.to_vec();
    memory.save(&mut numbers);
    numbers
}
