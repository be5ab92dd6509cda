//! Values of a scene that can be run and are probably not meant: other units, or another quantity.

use crate::compiled::Compiled;
use crate::language::{BodyInput, ConeInput, MaterialInput, Scene, SceneIn, ToolInput};
use mpm_grid::six_digits;

/// Angles of friction below this are taken for radians: 0.9 rad are 51.6 degrees.
const RADIANS: f64 = 0.9;

/// Coefficients of friction above this are taken for angles: 1.5 is the tangent of 56.3 degrees.
const ANGLE: f64 = 1.5;

/// Poisson's ratios from which on cells lock whose volume changes are not averaged.
const LOCKING: f64 = 0.495;

/// What in a scene is probably not meant, then what in its model is.
pub fn doubts(scene: &Scene, compiled: &Compiled) -> Vec<String> {
    implausible(scene).into_iter().chain(compiled.doubts()).collect()
}

/// What in a scene is probably not meant: sentences for people.
pub fn implausible(scene: &Scene) -> Vec<String> {
    match scene {
        Scene::PlaneStrain(scene) => of(scene),
        Scene::Axisymmetric(scene) => of(scene),
        Scene::Solid(scene) => of(scene),
    }
}

fn of<const D: usize, B>(scene: &SceneIn<D, B>) -> Vec<String> {
    let angles = scene.materials.iter().filter_map(|(name, law)| small_angle(name, law));
    let bodies = scene.bodies.iter().filter_map(|body| locks(scene, body));
    let friction = scene.tools.iter().filter_map(|tool| {
        let friction = tool.interface.friction.0;
        (friction > ANGLE).then(|| {
            format!(
                "the friction of tool `{}` is {}: it is a coefficient, the tangent of the angle of friction",
                tool.name,
                six_digits(friction)
            )
        })
    });
    let adhesion = scene.tools.iter().filter_map(|tool| strong_adhesion(scene, tool));
    angles.chain(bodies).chain(friction).chain(adhesion).collect()
}

/// An angle of friction that looks like radians.
fn small_angle(name: &str, law: &MaterialInput) -> Option<String> {
    let friction = match law {
        MaterialInput::MohrCoulomb { friction, .. } => friction.number(),
        MaterialInput::DruckerPrager { cone: ConeInput::Matched { friction, .. }, .. } => friction.number(),
        _ => None,
    };
    let friction = friction.filter(|it| 0.0 < *it && *it < RADIANS)?;
    Some(format!(
        "the angle of friction of material `{name}` is {} degrees; if it is meant in radians, it is {} degrees",
        six_digits(friction),
        six_digits((10.0 * friction.to_degrees()).round() / 10.0)
    ))
}

/// A body that hardly changes its volume, in cells that cannot keep theirs.
fn locks<const D: usize, B>(scene: &SceneIn<D, B>, body: &BodyInput<D>) -> Option<String> {
    let poisson = match scene.materials.get(&body.material)? {
        MaterialInput::Hencky { poisson, .. }
        | MaterialInput::NeoHooke { poisson, .. }
        | MaterialInput::VonMises { poisson, .. }
        | MaterialInput::Tresca { poisson, .. }
        | MaterialInput::MohrCoulomb { poisson, .. }
        | MaterialInput::DruckerPrager { poisson, .. } => poisson.0,
        MaterialInput::CamClay { .. } => return None,
    };
    (poisson >= LOCKING && body.mean_dilatation.is_none()).then(|| {
        format!(
            "body `{}` has Poisson's ratio {}: cells lock that cannot keep their volume, unless it is averaged by \
             `mean_dilatation`",
            body.name,
            six_digits(poisson)
        )
    })
}

/// Adhesion of a tool above the strength of a body that it meets.
fn strong_adhesion<const D: usize, B>(scene: &SceneIn<D, B>, tool: &ToolInput<D>) -> Option<String> {
    let adhesion = tool.interface.adhesion.0;
    let met = |body: &&BodyInput<D>| tool.bodies.is_empty() || tool.bodies.contains(&body.name);
    scene.bodies.iter().filter(met).find_map(|body| {
        let strength = match scene.materials.get(&body.material)? {
            MaterialInput::Tresca { undrained_strength, .. }
            | MaterialInput::VonMises { undrained_strength: Some(undrained_strength), .. } => {
                undrained_strength.number()?
            }
            MaterialInput::VonMises { yield_radius: Some(radius), .. } => radius.number()? / f64::sqrt(2.0),
            _ => return None,
        };
        (adhesion > strength).then(|| {
            format!(
                "the adhesion of tool `{}`, {}, is above the undrained strength of body `{}`, {}: the body yields before its \
                 surface slides",
                tool.name,
                six_digits(adhesion),
                body.name,
                six_digits(strength)
            )
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(law: &str, of_body: &str, interface: &str) -> Vec<String> {
        let scene = format!(
            "PlaneStrain(mesh: Box(axes: [Uniform(from: 0, to: 1, cells: 1), Uniform(from: 0, to: 1, cells: 1)]), basis: Gimp, \
             materials: {{\"m\": {law}}}, bodies: [(name: \"b\", material: \"m\", shape: Box(from: (0, 0), to: (1, 1)), \
             points_per_cell: 1{of_body})], tools: [(name: \"t\", parts: [Disc(centre: (0, 2), radius: 1)], \
             interface: ({interface}))], schedule: (steps: 1))"
        );
        implausible(&Scene::from_ron(&scene).unwrap())
    }

    #[test]
    fn what_is_usual_is_not_told_of() {
        let sand = "MohrCoulomb(young: 1, poisson: 0.3, cohesion: 0, friction: 30, dilation: 0)";
        assert_eq!(said(sand, "", "friction: 0.5"), [""; 0]);
        let clay = "Tresca(young: 1, poisson: 0.499, undrained_strength: 2)";
        assert_eq!(said(clay, ", mean_dilatation: Cell", "adhesion: 2"), [""; 0]);
        let smooth = "MohrCoulomb(young: 1, poisson: 0.3, cohesion: 1, friction: 0, dilation: 0)";
        assert_eq!(said(smooth, "", ""), [""; 0]);
    }

    #[test]
    fn other_units_are_told_of() {
        let radians = "MohrCoulomb(young: 1, poisson: 0.3, cohesion: 0, friction: 0.5236, dilation: 0)";
        let told = said(radians, "", "friction: 30");
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(
            told[0].contains("`m` is 0.5236 degrees; if it is meant in radians, it is 30 degrees"),
            "{told:?}"
        );
        assert!(told[1].contains("tool `t` is 30: it is a coefficient"), "{told:?}");
        let clay = "VonMises(young: 1, poisson: 0.4995, yield_radius: 1.4142)";
        let told = said(clay, "", "adhesion: 1.1");
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told[0].contains("body `b` has Poisson's ratio 0.4995"), "{told:?}");
        assert!(told[1].contains("is above the undrained strength of body `b`, 0.99999"), "{told:?}");
    }
}
