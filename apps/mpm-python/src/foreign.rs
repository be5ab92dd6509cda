//! Laws and loads that are written in Python: slow, for prototypes.
//!
//! They are called on the threads that compute, which take Python's lock for the time of a call; whoever waits for the run has
//! given it away. An exception stops the run and is raised where the next load step is asked for.

use crate::errors::Failure;
use mpm_assembly::{Body, LawOfBody};
use mpm_grid::{LoadFraction, Vector};
use mpm_material::{Elasticity, FieldInfo, History, Material, NoReturn, PointParameters, Update};
use mpm_scene::{Compiled, Scene};
use mpm_solver::observe::Cancellation;
use mpm_solver::{BodyForce, Model};
use nalgebra::{Matrix3, Vector3};
use pyo3::prelude::*;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// Most numbers that a law in Python remembers of a point.
const MOST: usize = 8;

/// Laws and loads by the names of the bodies that they are for, as Python hands them over.
#[derive(Default)]
pub(crate) struct Foreign {
    pub laws: Vec<(String, LawInPython)>,
    /// Functions of a position at rest and the load fraction, which return a force per volume.
    pub loads: Vec<(String, Py<PyAny>)>,
}

/// What Python says of a law: `update(strain, history)` answers `(stress, tangent, elastic strain, history, plastic)` in lists.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct LawInPython {
    update: Py<PyAny>,
    energy: Py<PyAny>,
    young: f64,
    poisson: f64,
    symmetric: bool,
    names: Vec<String>,
    initial: Vec<f64>,
}

/// The first exception, which stops the run.
#[derive(Clone, Default)]
pub(crate) struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// The exception, if there was one.
    pub(crate) fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    fn keep(&self, error: PyErr, cancellation: &Cancellation) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        cancellation.cancel();
    }
}

impl Foreign {
    /// Whether nothing is written in Python.
    pub(crate) fn is_empty(&self) -> bool {
        self.laws.is_empty() && self.loads.is_empty()
    }

    /// Gives the laws and loads to the bodies of a model.
    pub(crate) fn join(
        self,
        scene: &Scene,
        compiled: &mut Compiled,
        raised: &Raised,
        cancellation: &Cancellation,
    ) -> Result<(), Failure> {
        let is_of_revolution = matches!(scene, Scene::Axisymmetric(_));
        match compiled {
            Compiled::Plane(model) if is_of_revolution => {
                self.into_model(scene, model, LawOfBody::axisymmetric, (raised, cancellation))
            }
            Compiled::Plane(model) => self.into_model(scene, model, LawOfBody::new, (raised, cancellation)),
            Compiled::Solid(_) if is_of_revolution => {
                Err(Failure::input("laws and loads in Python are not for scenes with `twist`"))
            }
            Compiled::Solid(model) => self.into_model(scene, model, LawOfBody::new, (raised, cancellation)),
        }
    }

    fn into_model<const D: usize>(
        self,
        scene: &Scene,
        model: &mut Model<D>,
        law_of_body: fn(Law) -> LawOfBody<D>,
        (raised, cancellation): (&Raised, &Cancellation),
    ) -> Result<(), Failure> {
        for (name, law) in self.laws {
            let body = index(model, &name)?;
            if begins_under_stress(scene, body) {
                let reason = format!("body `{name}` has `initial`, from which a law in Python cannot begin");
                return Err(Failure::input(reason));
            }
            let law = Law::new(law, raised.clone(), cancellation.clone())
                .map_err(|reason| Failure::input(format!("law of body `{name}`: {reason}")))?;
            model.bodies[body].body.set_law(law_of_body(law), &[]).map_err(Failure::input)?;
        }
        for (name, force) in self.loads {
            let body = index(model, &name)?;
            let keeps_rest =
                |body: &dyn Body<D>| body.n_points() == 0 || body.point(0).reference_position.is_some();
            if !keeps_rest(&*model.bodies[body].body) {
                let reason =
                    format!("a load in Python on body `{name}` needs `Displacement` among `output.fields`");
                return Err(Failure::input(reason));
            }
            let (raised, cancellation) = (raised.clone(), cancellation.clone());
            model.loads.fields.push((body, Arc::new(Force { force, raised, cancellation })));
        }
        Ok(())
    }
}

fn index<const D: usize>(model: &Model<D>, name: &str) -> Result<usize, Failure> {
    model.bodies.iter().position(|body| body.name == name).ok_or_else(|| {
        let known: Vec<&str> = model.bodies.iter().map(|body| &body.name[..]).collect();
        Failure::input(format!("no body `{name}`; the scene has {}", known.join(", ")))
    })
}

fn begins_under_stress(scene: &Scene, body: usize) -> bool {
    match scene {
        Scene::PlaneStrain(scene) | Scene::Axisymmetric(scene) => scene.bodies[body].initial.is_some(),
        Scene::Solid(scene) => scene.bodies[body].initial.is_some(),
    }
}

/// A law that is written in Python.
struct Law {
    update: Py<PyAny>,
    energy: Py<PyAny>,
    elasticity: Elasticity,
    symmetric: bool,
    fields: Vec<FieldInfo>,
    initial: Remembered,
    raised: Raised,
    cancellation: Cancellation,
}

/// What a law in Python remembers of a point; numbers that it does not use are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Remembered([f64; MOST]);

impl History for Remembered {
    const NUMBERS: usize = MOST;
    // Each law has names of its own.
    const FIELDS: &'static [FieldInfo] = &[];

    fn store(&self, to: &mut Vec<f64>) {
        to.extend(self.0);
    }

    fn restore(from: &[f64]) -> Result<Self, String> {
        from.try_into().map(Self).map_err(|_| format!("expected {MOST} numbers, got {}", from.len()))
    }
}

impl Remembered {
    fn of(values: &[f64]) -> Self {
        let mut all = [0.0; MOST];
        all[..values.len()].copy_from_slice(values);
        Self(all)
    }
}

impl Law {
    fn new(law: LawInPython, raised: Raised, cancellation: Cancellation) -> Result<Self, String> {
        let elasticity =
            Elasticity::from_young_poisson(law.young, law.poisson).map_err(|error| error.to_string())?;
        if law.names.len() > MOST {
            return Err(format!(
                "it remembers {} numbers of a point, expected at most {MOST}",
                law.names.len()
            ));
        }
        // Names of fields live as long as the program; a process makes few laws.
        let field = |name: String| FieldInfo { name: name.leak(), components: 1, unit: "-" };
        Ok(Self {
            update: law.update,
            energy: law.energy,
            elasticity,
            symmetric: law.symmetric,
            fields: law.names.into_iter().map(field).collect(),
            initial: Remembered::of(&law.initial),
            raised,
            cancellation,
        })
    }

    fn remembered<'a>(&self, history: &'a Remembered) -> &'a [f64] {
        &history.0[..self.fields.len()]
    }

    /// Calls Python.
    fn call<T>(
        &self,
        function: &Py<PyAny>,
        strain: &Vector3<f64>,
        history: &Remembered,
        answer: impl Fn(&Bound<'_, PyAny>) -> PyResult<T>,
    ) -> Result<T, NoReturn> {
        let called = Python::try_attach(|py| {
            let arguments = (<[f64; 3]>::from(*strain), self.remembered(history).to_vec());
            let answered = function.bind(py).call1(arguments)?;
            // A trial that the law refuses: the load step is cut.
            if answered.is_none() { Ok(None) } else { answer(&answered).map(Some) }
        });
        match called {
            Some(Ok(Some(answer))) => Ok(answer),
            Some(Ok(None)) => Err(NoReturn { reason: "the law in Python finds no admissible state" }),
            Some(Err(error)) => {
                self.raised.keep(error, &self.cancellation);
                Err(NoReturn { reason: "the law in Python has raised an exception" })
            }
            None => Err(NoReturn { reason: "Python is going away" }),
        }
    }
}

/// Stress, tangent, elastic strain, history, and whether the point has yielded.
type Answer = ([f64; 3], [[f64; 3]; 3], [f64; 3], Vec<f64>, bool);

impl Material for Law {
    type History = Remembered;
    const PLASTIC: bool = true;

    fn has_symmetric_tangent(&self) -> bool {
        self.symmetric
    }

    fn initial(&self, _point: &PointParameters) -> Remembered {
        self.initial
    }

    fn history_fields(&self) -> Vec<FieldInfo> {
        self.fields.clone()
    }

    fn show(&self, history: &Remembered, to: &mut Vec<f64>) {
        to.extend(self.remembered(history));
    }

    fn stored_energy(&self, elastic_strain: &Vector3<f64>, history: &Remembered) -> f64 {
        self.call(&self.energy, elastic_strain, history, |answer| answer.extract()).unwrap_or(f64::NAN)
    }

    fn update(&self, trial: &Vector3<f64>, history: &Remembered) -> Result<Update<Remembered>, NoReturn> {
        let (stress, tangent, elastic, remembered, plastic) =
            self.call(&self.update, trial, history, |answer| answer.extract::<Answer>())?;
        let kirchhoff = Vector3::from(stress);
        let tangent = Matrix3::from_fn(|a, b| tangent[a][b]);
        Ok(Update {
            elastic_strain: Vector3::from(elastic),
            kirchhoff,
            tangent,
            secant: secants(trial, &kirchhoff, &tangent),
            plastic,
            history: Remembered::of(&remembered),
        })
    }

    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }
}

/// Secants (τ_a − τ_b)/(ε_a − ε_b) of the pairs (0,1), (1,2), (2,0); where strains are all but equal their limit for an
/// isotropic law, ½ (D_aa + D_bb − D_ab − D_ba).
fn secants(strain: &Vector3<f64>, stress: &Vector3<f64>, tangent: &Matrix3<f64>) -> Vector3<f64> {
    /// Below it the difference of stresses has lost more digits than the limit is wrong by.
    const CLOSE: f64 = 1e-5;
    let secant = |a: usize, b: usize| {
        let apart = strain[a] - strain[b];
        if apart.abs() > CLOSE {
            (stress[a] - stress[b]) / apart
        } else {
            0.5 * (tangent[(a, a)] + tangent[(b, b)] - tangent[(a, b)] - tangent[(b, a)])
        }
    };
    Vector3::new(secant(0, 1), secant(1, 2), secant(2, 0))
}

/// A force per volume that is written in Python.
struct Force {
    force: Py<PyAny>,
    raised: Raised,
    cancellation: Cancellation,
}

impl fmt::Debug for Force {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Force")
    }
}

impl<const D: usize> BodyForce<D> for Force {
    fn force(&self, rest: &Vector<D>, at: LoadFraction) -> Vector<D> {
        let called = Python::try_attach(|py| {
            let arguments = (rest.iter().copied().collect::<Vec<f64>>(), at.total());
            self.force.bind(py).call1(arguments)?.extract::<Vec<f64>>()
        });
        match called {
            Some(Ok(force)) => Vector::from_fn(|d, _| force[d]),
            Some(Err(error)) => {
                self.raised.keep(error, &self.cancellation);
                Vector::zeros()
            }
            None => Vector::zeros(),
        }
    }
}
