//! Ranks that share a run over MPI.

use crate::shares::shares;
use crate::taken::Taken;
use mpm_cli::{Complaint, Crew};
use mpm_cluster::{Bordered, Cluster, Exchange, Gathered, Wire};
use mpm_linear::{Choice, LinearSolver};
use mpm_petsc::{MpiWire, Owners, Petsc, Session};
use mpm_scene::{Compiled, ShareOfPoints};
use mpm_solver::observe::Observer;
use mpm_solver::{Error, Model, State, Summary};
use std::rc::Rc;

/// The ranks of `mpirun`.
pub(crate) struct MpiCrew {
    session: Rc<Session>,
    wire: MpiWire,
}

impl MpiCrew {
    pub(crate) fn of(session: Rc<Session>) -> Self {
        Self { wire: MpiWire::of(&session), session }
    }

    /// This rank of a model.
    fn cluster<const D: usize>(&self, model: &Model<D>) -> Rc<Cluster<D, MpiWire>> {
        let session = self.session.clone();
        let cluster = Cluster::new(MpiWire::of(&session), model).with_solver(move |model, exchange| {
            // PETSc's solvers here know the blocks of nodes and a few unknowns besides, and no further field on the nodes.
            if model.bodies.iter().any(|named| named.body.regularisation().is_some()) {
                return Box::new(Gathered::new(model, exchange)) as Box<dyn LinearSolver>;
            }
            let nodes = Rc::new(NodesOfRanks(exchange.clone()));
            let choice = model.choice().unwrap_or(Choice::Auto);
            let of_nodes = Petsc::new(session.clone(), nodes.clone(), nodes, choice);
            Box::new(Bordered::new(Box::new(of_nodes), exchange))
        });
        Rc::new(cluster)
    }

    fn run_model<const D: usize>(
        &self,
        model: &mut Model<D>,
        state: Option<&State>,
        observer: &mut dyn Observer,
    ) -> Result<Summary, Error> {
        let cluster = self.cluster(model);
        let mut whole = cluster.whole(observer);
        let outcome = match state {
            None => mpm_solver::run_on(model, cluster.clone(), &mut whole),
            Some(state) => mpm_solver::resume_on(model, cluster.clone(), state, &mut whole),
        };
        self.tell_taken(&cluster);
        self.tell_unused();
        outcome
    }

    /// Ranks on the machine of this one, with it: those whose machines have the same name.
    fn on_machine(&self) -> usize {
        let name = std::fs::read("/proc/sys/kernel/hostname").unwrap_or_default();
        let to_all: Vec<(usize, Vec<u8>)> = (0..self.session.size()).map(|rank| (rank, name.clone())).collect();
        self.wire.exchange(&to_all).iter().filter(|it| it.1 == name).count()
    }

    /// Says what every rank has sent, held and taken, where the option is given.
    fn tell_taken<const D: usize>(&self, cluster: &Cluster<D, MpiWire>) {
        if self.session.option(c"-mpm_ranks").is_none() {
            return;
        }
        let own = Taken::of(cluster.exchange().wire().traffic()).numbers();
        let mut all = vec![0.0; own.len() * self.session.size()];
        self.wire.gather(&own, &mut all);
        if self.leads() {
            let lines = all.as_chunks().0.iter().enumerate();
            lines.for_each(|(rank, it)| eprintln!("{}", Taken::line(rank, *it)));
        }
    }

    /// Warns of options that PETSc had no use for: most are misspelt.
    fn tell_unused(&self) {
        let unused = self.session.unused_options().unwrap_or_default();
        if self.leads() {
            unused.iter().for_each(|name| eprintln!("warning: PETSc has not asked for the option -{name}"));
        }
    }
}

impl Crew for MpiCrew {
    fn leads(&self) -> bool {
        self.session.rank() == 0
    }

    /// One a rank: ranks fill the cores.
    fn threads(&self) -> Option<u16> {
        Some(1)
    }

    fn share(&self) -> Option<ShareOfPoints> {
        let (rank, ranks) = (self.session.rank(), self.session.size());
        (ranks > 1).then(|| ShareOfPoints { rank, ranks, on_machine: self.on_machine() })
    }

    fn agree(&self, here: Result<(), Complaint>) -> Result<(), Complaint> {
        let mut codes = vec![0.0; self.session.size()];
        self.wire.gather(&[here.as_ref().err().map_or(0.0, |it| f64::from(it.code()))], &mut codes);
        match codes.iter().position(|&code| code > 0.0) {
            Some(first) if first != self.session.rank() => Err(Complaint::told(codes[first] as u8)),
            _ => here,
        }
    }

    fn run(
        &self,
        compiled: &mut Compiled,
        from: Option<&State>,
        observer: &mut dyn Observer,
    ) -> Result<Summary, Error> {
        match compiled {
            Compiled::Plane(model) => self.run_model(model, from, observer),
            Compiled::Solid(model) => self.run_model(model, from, observer),
        }
    }

    fn shares(&self, compiled: &mut Compiled) -> Result<Option<String>, Complaint> {
        let told = match compiled {
            Compiled::Plane(model) => shares(&self.cluster(model), model),
            Compiled::Solid(model) => shares(&self.cluster(model), model),
        };
        told.map(Some).map_err(Complaint::input)
    }
}

/// What the linear solver asks of the ranks.
struct NodesOfRanks<const D: usize>(Rc<Exchange<D, MpiWire>>);

impl<const D: usize> Owners for NodesOfRanks<D> {
    fn owner(&self, node: [u32; 3]) -> usize {
        self.0.cuts().owner(std::array::from_fn(|d| node[d]))
    }
}

impl<const D: usize> Wire for NodesOfRanks<D> {
    fn rank(&self) -> usize {
        self.0.wire().rank()
    }

    fn size(&self) -> usize {
        self.0.wire().size()
    }

    fn gather(&self, own: &[f64], all: &mut [f64]) {
        self.0.wire().gather(own, all);
    }

    fn exchange(&self, out: &[(usize, Vec<u8>)]) -> Vec<(usize, Vec<u8>)> {
        self.0.wire().exchange(out)
    }
}
