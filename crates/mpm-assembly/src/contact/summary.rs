//! What a history tells of a tool.

use super::corners::{Contact, NearCorner};
use crate::contribution::{Inadmissible, OfParts, Recorded};
use mpm_contact::{Mode, Pose, moment};
use mpm_grid::{Block, Vector, six_digits};
use nalgebra::Vector3;

/// Penetration over the width of a domain with which no step is accepted: a tool that gets farther passes through.
const TOO_DEEP: f64 = 0.5;

/// Sums over the corners that a tool touches.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Summary<const D: usize> {
    /// Force on the tool `[F]`, and its moment about the tool's reference point `[F L]`.
    pub force: Vector<D>,
    pub moment: Vector3<f64>,
    /// Where the reference point stands `[L]`.
    pub position: Vector<D>,
    /// How far the tool has turned about its axis `[degrees]`.
    pub angle: f64,
    /// Its rotation since it was at rest.
    pub rotation: Block<D>,
    /// Area of the tool's surface in the bodies `[L^(D-1)]`.
    pub area: f64,
    /// Corners that press, and corners that slip with a force.
    pub closed: u64,
    pub slipping: u64,
    /// Largest penetration over the width of a domain `[-]`.
    pub deepest: f64,
}

impl<const D: usize> Summary<D> {
    /// Of a tool that touches nothing.
    pub fn untouched(pose: &Pose<D>, about: &Vector<D>, angle: f64) -> Self {
        Self {
            force: Vector::zeros(),
            moment: Vector3::zeros(),
            position: pose.place(about),
            angle: angle.to_degrees(),
            rotation: *pose.rotation(),
            area: 0.0,
            closed: 0,
            slipping: 0,
            deepest: 0.0,
        }
    }

    /// Takes a corner in.
    pub fn add(&mut self, corner: &NearCorner<D>, contacts: &[Contact<D>]) {
        self.area += corner.area;
        for contact in contacts {
            let response = &contact.response;
            self.force -= contact.force();
            self.moment -= moment(&(contact.position - self.position), &response.force);
            self.closed += u64::from(response.normal_force != 0.0);
            self.slipping += u64::from(response.mode == Mode::Slipping && response.tangential.norm() > 0.0);
            if response.closed {
                self.deepest = self.deepest.max(-response.gap / contact.law.width);
            }
        }
    }

    /// Refuses a state in which the tool is about to pass through a body.
    ///
    /// # Errors
    /// How deep it is.
    pub fn check_depth(&self) -> Result<(), Inadmissible> {
        if self.deepest <= TOO_DEEP {
            return Ok(());
        }
        Err(Inadmissible::Contribution(format!(
            "a body has entered it by {} of a point's width, expected at most {TOO_DEEP}: the contact is too soft for the \
             pressure; its interface can have a larger `stiffness`, or `augment`",
            six_digits(self.deepest)
        )))
    }

    /// Columns below `tool/<name>/`.
    pub fn columns(&self, name: &str, turns: bool) -> Vec<Recorded> {
        let path = |column: &str| format!("tool/{name}/{column}");
        // Of a tool that turns about the axis of bodies of revolution the last components are a torque and an angle.
        let coordinates = if turns { D - 1 } else { D };
        let moment = match D {
            _ if turns => vec![self.force[D - 1]],
            2 => vec![self.moment.z],
            _ => self.moment.iter().copied().collect(),
        };
        let angle = if turns { self.position[D - 1].to_degrees() } else { self.angle };
        let vector = |v: &Vector<D>| v.iter().take(coordinates).copied().collect::<Vec<_>>();
        let mut columns = vec![
            Recorded::real(path("force"), vector(&self.force)),
            Recorded::real(path("moment"), moment),
            Recorded::real(path("position"), vector(&self.position)).of_parts(OfParts::Same),
            Recorded::real(path("angle"), [angle]).of_parts(OfParts::Same),
            Recorded::real(path("area"), [self.area]),
            Recorded::count(path("closed"), self.closed),
            Recorded::count(path("slipping"), self.slipping),
            Recorded::real(path("deepest"), [self.deepest]).of_parts(OfParts::Largest),
        ];
        // In the plane and about one axis the angle says it all.
        if D == 3 && !turns {
            let rotation = Recorded::real(path("rotation"), self.rotation.transpose().as_slice());
            columns.push(rotation.of_parts(OfParts::Same));
        }
        columns
    }
}
