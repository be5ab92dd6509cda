//! Systems of several ranks against the direct solver of one: this program starts itself by `mpirun`.

mod elasticity;

use elasticity::Lattice;
use mpm_cluster::Wire;
use mpm_linear::{Choice, Factorization, Hints, LatticePlaces, LinearSolver, Matrix, Method, Pattern};
use mpm_petsc::{MpiWire, Petsc, Session};
use std::process::{Command, ExitCode};
use std::rc::Rc;

/// Names of the cases, and options of PETSc.
const CASES: &[(&str, &[&str])] = &[
    ("wire", &[]),
    ("plane", &[]),
    ("space", &[]),
    ("space", &["-pc_type", "mg"]),
    ("space", &["-pc_type", "gamg", "-pc_gamg_threshold", "0.01"]),
    (
        "space",
        &[
            "-pc_type",
            "hypre",
            "-pc_hypre_boomeramg_strong_threshold",
            "0.5",
            "-pc_hypre_boomeramg_nodal_coarsen",
            "6",
            "-pc_hypre_boomeramg_vec_interp_variant",
            "2",
        ],
    ),
    ("space", &["-ksp_type", "preonly", "-pc_type", "cholesky", "-pc_factor_mat_solver_type", "mumps"]),
    ("direct", &[]),
    ("skewed", &[]),
    ("indefinite", &[]),
    ("failures", &[]),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [first, case, options @ ..] = &arguments[..]
        && first == "--case"
    {
        // The other ranks would wait for one that has panicked; mpirun ends them where it aborts.
        std::panic::set_hook(Box::new(|panic| {
            eprintln!("{panic}");
            std::process::abort();
        }));
        let session = Session::start(options).expect("MPI and PETSc start");
        run(case, &session);
        let unused = session.unused_options().expect("PETSc tells");
        assert!(unused.is_empty() || *case != "space", "not asked for: {unused:?}");
        return ExitCode::SUCCESS;
    }
    let program = std::env::current_exe().expect("a program has a path");
    let mut failed = 0;
    for (case, options) in CASES {
        for ranks in ["1", "2", "3", "4"] {
            let mut command = Command::new("mpirun");
            command.args(["-n", ranks, "--oversubscribe"]).arg(&program).args(["--case", case]).args(*options);
            command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
            command.env("OMP_NUM_THREADS", "1");
            let is_well = command.status().expect("mpirun is installed").success();
            println!(
                "{} {case} {} on {ranks} ranks",
                if is_well { "ok    " } else { "FAILED" },
                options.join(" ")
            );
            failed += i32::from(!is_well);
        }
    }
    ExitCode::from(u8::from(failed > 0))
}

fn run(case: &str, session: &Rc<Session>) {
    match case {
        "wire" => wire(&MpiWire::of(session)),
        "plane" => agrees(session, &Lattice::<2>::of([40, 30]), Choice::Auto, 1e-10),
        "space" => agrees(session, &Lattice::<3>::of([14, 9, 7]), Choice::Auto, 1e-10),
        "direct" => agrees(session, &Lattice::<3>::of([8, 6, 5]), Choice::Direct, 1e-10),
        "skewed" => agrees(session, &Lattice::<3>::of([10, 6, 5]).skewed(), Choice::Auto, 1e-10),
        "indefinite" => indefinite(session),
        "failures" => failures(session),
        _ => panic!("no case {case}"),
    }
}

fn wire(wire: &dyn Wire) {
    let (me, n) = (wire.rank(), wire.size());
    let mut all = vec![0.0; 2 * n];
    wire.gather(&[me as f64, 7.0], &mut all);
    assert!(all.chunks_exact(2).enumerate().all(|(rank, it)| it == [rank as f64, 7.0]));
    // Rank q sends q + 1 times the number of the receiver to every rank that is not above it, an empty message to itself.
    let bytes =
        |from: usize, to: usize| if from == to { Vec::new() } else { vec![to as u8; 1000 * (from + 1)] };
    let out: Vec<(usize, Vec<u8>)> = (0..=me).map(|to| (to, bytes(me, to))).collect();
    let incoming = wire.exchange(&out);
    let expected: Vec<(usize, Vec<u8>)> = (me..n).map(|from| (from, bytes(from, me))).collect();
    assert!(incoming == expected, "rank {me}");
    // Nobody sends anything.
    assert!(wire.exchange(&[]).is_empty());
}

/// The part of a lattice that a rank has: its cells, all nodes that they reach, and its own nodes.
struct Part {
    index: Vec<[u32; 3]>,
    column_start: Vec<usize>,
    row: Vec<usize>,
    values: Vec<f64>,
    held: Vec<bool>,
    rhs: Vec<f64>,
}

/// Solves on all ranks and on this one alone; compares the solutions on all nodes of this rank.
fn agrees<const D: usize>(session: &Rc<Session>, lattice: &Lattice<D>, choice: Choice, within: f64) {
    let wire: Rc<dyn Wire> = Rc::new(MpiWire::of(session));
    let n = wire.size();
    let owner = lattice.owner(n);
    let expected = alone(lattice);
    let mut solver = Petsc::new(session.clone(), wire.clone(), Rc::new(owner), choice);
    let part = lattice_part(lattice, wire.rank(), n);
    let mut before: Vec<f64> = Vec::new();
    // The second time the pattern is kept, the third time the matrix is twice the first.
    for (round, factor) in [1.0, 1.0, 2.0].into_iter().enumerate() {
        let values: Vec<f64> = part.values.iter().map(|it| it * factor).collect();
        let mut x = part.rhs.clone();
        let solved = with_system(lattice, &part, &values, |pattern, hints, matrix| {
            let analysis = solver.analyse(pattern, hints).expect("memory suffices");
            assert_eq!(analysis == mpm_linear::Analysis::Reused, round > 0);
            solver.factorise(matrix).expect("it is definite");
            solver.solve(matrix, &mut x, 1e-11).expect("it converges")
        });
        assert!(solved.residual.is_some_and(|it| it < 1e-9), "{solved:?}");
        if choice == Choice::Auto && wire.rank() == 0 && round == 0 {
            println!("{D}-D on {n} ranks: {solved:?}");
            // Our own cycle; a coarse matrix that is not the product takes more.
            let most = if session.option(c"-pc_type").is_none() { 20 } else { 60 };
            assert!(solved.iterations < most || lattice.is_skewed(), "{solved:?}");
        }
        let largest = expected.values().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (v, index) in part.index.iter().enumerate() {
            for i in 0..D {
                let (found, wanted) = (factor * x[v * D + i], expected[index][i]);
                assert!((found - wanted).abs() < within * largest, "{index:?}: {found} is not {wanted}");
                assert!(!part.held[v * D + i] || found == 0.0, "held components stay");
            }
        }
        // Same bits where everything is the same; MUMPS and algebraic multigrid of three ranks do not promise that.
        if round == 1 && choice == Choice::Auto && session.option(c"-pc_type").is_none() {
            assert_eq!(before, x);
        }
        before = x;
    }
}

fn with_system<const D: usize, R>(
    lattice: &Lattice<D>,
    part: &Part,
    values: &[f64],
    see: impl FnOnce(Pattern<'_>, &Hints<'_>, Matrix<'_>) -> R,
) -> R {
    let pattern = if lattice.is_skewed() {
        Pattern::unsymmetric(&part.column_start, &part.row, D)
    } else {
        Pattern::symmetric(&part.column_start, &part.row, D)
    };
    let lines = lattice.lines();
    let places = LatticePlaces { index: &part.index, lines: &lines, periods: [None; 3], degree: [1; 3] };
    let position = |v: usize| part.index[v].map(f64::from);
    let is_held = |equation: usize| part.held[equation];
    let hints = Hints { position: Some(&position), is_held: Some(&is_held), ..Hints::on_lattice(places) };
    see(pattern, &hints, Matrix { pattern, values })
}

/// The solution on one rank, by node.
fn alone<const D: usize>(lattice: &Lattice<D>) -> std::collections::BTreeMap<[u32; 3], [f64; D]> {
    let part = lattice_part(lattice, 0, 1);
    let mut x = part.rhs.clone();
    let mut solver = Factorization::new();
    with_system(lattice, &part, &part.values, |pattern, hints, matrix| {
        solver.analyse(pattern, hints).expect("memory suffices");
        solver.factorise(matrix).expect("it is regular");
        solver.solve(matrix, &mut x, 1e-12).expect("it is accurate");
    });
    part.index.iter().zip(x.as_chunks().0).map(|(index, x)| (*index, *x)).collect()
}

fn lattice_part<const D: usize>(lattice: &Lattice<D>, rank: usize, ranks: usize) -> Part {
    let (index, column_start, row, values) = lattice.assembled(rank, ranks);
    let held = index.iter().flat_map(|it| [it[0] == 0; D]).collect();
    let rhs = index.iter().flat_map(|it| lattice.force(*it)).collect();
    Part { index, column_start, row, values, held, rhs }
}

/// What the iteration cannot solve is factorised, and the signs of the pivots are those that one rank finds.
fn indefinite(session: &Rc<Session>) {
    let lattice = Lattice::<3>::of([9, 6, 5]).shifted();
    let wire: Rc<dyn Wire> = Rc::new(MpiWire::of(session));
    let part = lattice_part(&lattice, wire.rank(), wire.size());
    let owner = lattice.owner(wire.size());
    let mut solver = Petsc::new(session.clone(), wire.clone(), Rc::new(owner), Choice::Iterative);
    let mut x = part.rhs.clone();
    let (factored, solved) = with_system(&lattice, &part, &part.values, |pattern, hints, matrix| {
        solver.analyse(pattern, hints).expect("memory suffices");
        let factored = solver.factorise(matrix).expect("it is regular");
        (factored, solver.solve(matrix, &mut x, 1e-10).expect("it is factorised"))
    });
    assert_eq!(solved.method, Method::Other("MUMPS"));
    let inertia = solved.taken_over.and_then(|it| it.inertia).or(factored.inertia).expect("MUMPS tells");
    let whole = lattice_part(&lattice, 0, 1);
    let mut direct = Factorization::new();
    let expected = with_system(&lattice, &whole, &whole.values, |pattern, hints, matrix| {
        direct.analyse(pattern, hints).expect("memory suffices");
        direct.factorise(matrix).expect("it is regular").inertia.expect("LBLT tells")
    });
    assert!(expected.negative > 0);
    assert_eq!(inertia, expected);
    let expected = alone(&lattice);
    let largest = expected.values().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (index, x) in part.index.iter().zip(x.as_chunks::<3>().0) {
        (0..3).for_each(|i| assert!((x[i] - expected[index][i]).abs() < 1e-7 * largest, "{index:?}"));
    }
}

/// What fails on one rank ends the call on all, with a reason on the one; a singular matrix on all.
fn failures(session: &Rc<Session>) {
    let lattice = Lattice::<2>::of([30, 20]);
    let wire: Rc<dyn Wire> = Rc::new(MpiWire::of(session));
    let last = wire.rank() + 1 == wire.size();
    let part = lattice_part(&lattice, wire.rank(), wire.size());
    let owner = lattice.owner(wire.size());
    let mut solver = Petsc::new(session.clone(), wire.clone(), Rc::new(owner), Choice::Auto);
    let mut values = part.values.clone();
    if last {
        values[5] = f64::NAN;
    }
    with_system(&lattice, &part, &values, |pattern, hints, matrix| {
        solver.analyse(pattern, hints).expect("memory suffices");
        assert_eq!(solver.factorise(matrix).is_err(), last);
    });
    with_system(&lattice, &part, &part.values, |_, _, matrix| {
        solver.factorise(matrix).expect("it is definite");
        let mut x = part.rhs.clone();
        if last {
            x[3] = f64::INFINITY;
        }
        assert_eq!(solver.solve(matrix, &mut x, 1e-8).is_err(), last);
    });
    // Nothing holds the body, and the load is not in balance.
    let floats = lattice.floating();
    let part = lattice_part(&floats, wire.rank(), wire.size());
    let free = Part { held: vec![false; part.held.len()], ..part };
    with_system(&floats, &free, &free.values, |pattern, hints, matrix| {
        solver.analyse(pattern, hints).expect("memory suffices");
        let mut x = free.rhs.clone();
        let outcome = solver.factorise(matrix).and_then(|_| solver.solve(matrix, &mut x, 1e-8));
        let failure = outcome.expect_err("no solution exists");
        assert!(!failure.to_string().is_empty());
    });
    // Unknowns that belong to no node are refused by name.
    let (start, row) = ([0, 2, 4, 5], [0, 1, 1, 2, 2]);
    let pattern = Pattern { blocks: 1, ..Pattern::symmetric(&start, &row, 1) };
    let pattern = Pattern { block: 2, ..pattern };
    solver.analyse(pattern, &Hints::default()).expect("it is refused later");
    let refused = solver.factorise(Matrix { pattern, values: &[1.0; 5] }).expect_err("it is refused");
    assert!(refused.to_string().contains("displacement"), "{refused}");
}
