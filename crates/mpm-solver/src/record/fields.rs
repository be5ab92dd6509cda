//! Fields of the material points, computed when they are asked for.

use crate::model::{Model, NamedBody, NamedContribution};
use crate::observe::{Field, Fields};
use mpm_assembly::{Body, Joined, views};
use mpm_basis::DomainReport;
use mpm_basis::parallel::{fill, parts};
use mpm_grid::{LoadFraction, Mesh, Vector};
use mpm_material::{SymmetricTensor, log_strain};
use nalgebra::Matrix3;

/// Points of a parallel task.
const BLOCK: usize = 512;

/// The material points of all bodies, one after the other.
pub(crate) struct BodyFields<'a, const D: usize> {
    pub bodies: &'a [NamedBody<D>],
    pub contributions: &'a [NamedContribution<D>],
    /// The mesh in which domains are judged.
    pub mesh: &'a Mesh<D>,
}

/// Hands the points of a model on as observers see them at a load fraction.
pub fn look_at_points<const D: usize, R>(
    model: &Model<D>,
    at: LoadFraction,
    look: impl FnOnce(&dyn Fields) -> R,
) -> R {
    let mesh = mesh_after(model, at, &Mesh::at_rest(&model.layout));
    look(&BodyFields { bodies: &model.bodies, contributions: &model.contributions, mesh: &mesh })
}

/// The mesh that the points meet next; `present` where the motion cannot place it.
pub(crate) fn mesh_after<const D: usize>(model: &Model<D>, at: LoadFraction, present: &Mesh<D>) -> Mesh<D> {
    model.motion.mesh_at(&model.layout, at).unwrap_or_else(|_| present.clone())
}

impl<const D: usize> BodyFields<'_, D> {
    /// Numbers of every point, which `each` writes by its body and the numbers of both.
    fn collect(
        &self,
        components: usize,
        each: impl Fn(&dyn Body<D>, [usize; 2], &mut [f64]) + Sync,
    ) -> Vec<f64> {
        let mut values = vec![0.0; self.n_points() * components];
        let mut rest = &mut values[..];
        for (index, named) in self.bodies.iter().enumerate() {
            let n = named.body.n_points();
            let (own, after) = rest.split_at_mut(n * components);
            rest = after;
            let lengths = (0..n).step_by(BLOCK).map(|first| (n - first).min(BLOCK) * components);
            fill(parts(own, lengths).collect(), &|block, values| {
                for (k, of_point) in values.chunks_exact_mut(components).enumerate() {
                    each(&*named.body, [index, block * BLOCK + k], of_point);
                }
            });
        }
        values
    }
}

impl<const D: usize> BodyFields<'_, D> {
    fn diagnose(&self, value: impl Fn(&DomainReport) -> f64) -> Vec<f64> {
        self.bodies.iter().flat_map(|named| named.body.diagnose(self.mesh)).map(|it| value(&it)).collect()
    }

    /// What the laws of the bodies remember under the name of the field; 0 where a law does not know it.
    fn remembered(&self, field: Field) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.n_points() * field.components());
        let mut history = Vec::new();
        for named in self.bodies {
            let infos = named.body.history_fields();
            let place = infos.iter().position(|info| Field::from(*info) == field);
            let first = place.map(|place| infos[..place].iter().map(|info| info.components).sum::<usize>());
            for point in 0..named.body.n_points() {
                let Some(first) = first else {
                    values.extend(std::iter::repeat_n(0.0, field.components()));
                    continue;
                };
                history.clear();
                named.body.history(point, &mut history);
                values.extend(&history[first..first + field.components()]);
            }
        }
        values
    }

    /// What contributions know of the points under the name of the field; none where no contribution has it.
    fn of_contributions(&self, field: Field) -> Option<Vec<f64>> {
        let bodies: Vec<&dyn Body<D>> = self.bodies.iter().map(|named| &*named.body).collect();
        let mut joined: Option<Vec<f64>> = None;
        for contribution in self.contributions.iter().map(|named| &named.contribution) {
            let Some(own) = contribution.point_fields().iter().find(|it| Field::from(it.info) == field) else {
                continue;
            };
            let values = contribution.point_field(field.name(), &bodies);
            joined = Some(match (joined, own.joined) {
                (None, _) => values,
                (Some(so_far), Joined::Sum) => so_far.iter().zip(values).map(|(a, b)| a + b).collect(),
                (Some(so_far), Joined::Least) => so_far.iter().zip(values).map(|(a, b)| a.min(b)).collect(),
            });
        }
        joined
    }

    /// Four corners of (x, y) per point, see [`Field::OUTLINE`].
    fn plane_outlines(&self) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.n_points() * Field::OUTLINE.components());
        for named in self.bodies {
            for (point, view) in views(&*named.body).enumerate() {
                let corners = named.body.outline(point);
                let last = corners.last().copied().unwrap_or(view.position);
                let corners = corners.into_iter().chain(std::iter::repeat(last)).take(4);
                values.extend(corners.flat_map(|x| [x[0], x[1]]));
            }
        }
        values
    }
}

impl<const D: usize> Fields for BodyFields<'_, D> {
    fn n_points(&self) -> usize {
        self.bodies.iter().map(|named| named.body.n_points()).sum()
    }

    fn positions(&self) -> Vec<f64> {
        self.collect(3, |body, [_, point], out| out.copy_from_slice(&spatial(&body.point(point).position)))
    }

    fn field(&self, field: Field) -> Vec<f64> {
        match field {
            Field::DOMAIN_MEASURE => self.diagnose(|it| it.measure),
            Field::SMALLEST_CORNER_WEIGHT => self.diagnose(|it| it.smallest_weight),
            Field::SINGLE_CORNER_NODES => self.diagnose(|it| it.single_corner_nodes as f64),
            Field::CORNERS_OUTSIDE => self.diagnose(|it| it.corners_outside as f64),
            Field::FALLEN_BACK => self.diagnose(|it| f64::from(u8::from(it.fallen_back))),
            Field::OUTLINE => self.plane_outlines(),
            _ if Field::OF_POINTS.contains(&field) => {
                self.collect(field.components(), |body, numbers, out| point_field(field, body, numbers, out))
            }
            _ => self.of_contributions(field).unwrap_or_else(|| self.remembered(field)),
        }
    }

    fn outlines(&self) -> Vec<Vec<[f64; 3]>> {
        let outline = |named: &NamedBody<D>, point| named.body.outline(point).iter().map(spatial).collect();
        self.bodies
            .iter()
            .flat_map(|named| (0..named.body.n_points()).map(move |point| outline(named, point)))
            .collect()
    }
}

/// Writes a field of the point's state.
fn point_field<const D: usize>(field: Field, body: &dyn Body<D>, [number, point]: [usize; 2], out: &mut [f64]) {
    let view = body.point(point);
    match field {
        Field::DISPLACEMENT => {
            let rest = view.reference_position.unwrap_or(view.position);
            out.copy_from_slice(&spatial(&(view.position - rest)));
        }
        Field::DEFORMATION_GRADIENT => {
            let mut f = Matrix3::identity();
            for i in 0..D {
                for j in 0..D {
                    f[(i, j)] = view.deformation_gradient[(i, j)];
                }
            }
            f[(2, 2)] = view.hoop_stretch.unwrap_or(f[(2, 2)]);
            out.copy_from_slice(f.transpose().as_slice());
        }
        Field::CAUCHY_STRESS => write(out, &body.kirchhoff(point), 1.0 / view.volume_ratio),
        Field::ELASTIC_STRAIN => write(out, &log_strain(&view.elastic_excess), 1.0),
        Field::VOLUME => out[0] = view.volume_ratio * view.reference_volume,
        Field::VOLUME_RATIO => out[0] = view.volume_ratio,
        Field::RHO => out[0] = rho(&body.kirchhoff(point)),
        Field::PLASTIC => out[0] = f64::from(u8::from(view.plastic)),
        Field::BODY => out[0] = number as f64,
        Field::ANGLE => out[0] = view.angle.unwrap_or(0.0),
        _ => unreachable!("worked out from the domains, or remembered by laws"),
    }
}

/// Padded with zeros to three components.
fn spatial<const D: usize>(x: &Vector<D>) -> [f64; 3] {
    std::array::from_fn(|i| if i < D { x[i] } else { 0.0 })
}

fn write(out: &mut [f64], t: &SymmetricTensor, scale: f64) {
    out.copy_from_slice(&[t.xx, t.xy, t.zx, t.xy, t.yy, t.yz, t.zx, t.yz, t.zz].map(|x| x * scale));
}

/// `|dev τ|`.
fn rho(tau: &SymmetricTensor) -> f64 {
    let mean = tau.trace() / 3.0;
    let deviator = SymmetricTensor { xx: tau.xx - mean, yy: tau.yy - mean, zz: tau.zz - mean, ..*tau };
    deviator.norm()
}
