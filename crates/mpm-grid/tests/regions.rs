//! Regions against a search of all nodes, and on grids too large to search.

use mpm_grid::{Axis, Layout, Mesh, NodeId, NodeKind, NodeSpace, Region, Span, Vector};

fn searched<const D: usize>(layout: &Layout<D>, holds: impl Fn(Vector<D>) -> bool) -> Vec<NodeId> {
    let all = (0..layout.lattice().n_nodes()).map(|i| NodeId::from_index(i).unwrap());
    all.filter(|&node| holds(layout.position(node))).collect()
}

fn vertices<const D: usize>(layout: &Layout<D>) -> NodeSpace<D> {
    NodeSpace::vertices(layout.lattice())
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-10
}

fn solid() -> Layout<3> {
    let axes = [
        Axis::uniform(-3.0, 3.0, 6).unwrap(),
        Axis::geometric(0.0, 3.0, 4, 8.0).unwrap(),
        Axis::uniform(0.0, 2.0, 2).unwrap(),
    ];
    Layout::on_axes(axes).unwrap()
}

#[test]
fn regions_of_a_box() {
    let layout = solid();
    let y = 3.0 / 15.0;
    let plane = |axis, at| Region::Plane { axis, at };
    let same = |region: Region<3>, holds: &dyn Fn(Vector<3>) -> bool, count| {
        let nodes = region.nodes(&vertices(&layout), &layout);
        assert_eq!(nodes, searched(&layout, holds), "{region:?}");
        assert_eq!(nodes.len(), count, "{region:?}");
    };
    same(Region::Everywhere, &|_| true, 7 * 5 * 3);
    same(Region::All(vec![]), &|_| true, 7 * 5 * 3);
    same(plane(0, -1.0), &|x| near(x[0], -1.0), 5 * 3);
    same(plane(1, y), &|x| near(x[1], y), 7 * 3);
    same(plane(2, 0.5), &|_| false, 0);
    same(plane(3, 0.0), &|_| false, 0);
    let (from, to) = (Vector::<3>::new(-1.0, 0.1, 1.0), Vector::<3>::new(9.0, f64::INFINITY, 1.5));
    let inside = |x: Vector<3>| x[0] > -1.5 && x[1] > 0.1 && near(x[2], 1.0);
    same(Region::Box { from, to }, &inside, 5 * 4);
    same(
        Region::Point(Vector::<3>::new(2.0, 3.0, 0.0)),
        &|x| near((x - Vector::<3>::new(2.0, 3.0, 0.0)).norm(), 0.0),
        1,
    );
    same(Region::Point(Vector::<3>::new(2.0, 3.0, 1e-6)), &|_| false, 0);
    let circle = || Region::Circle { centre: [0.0, 0.0], radius: 3.0 };
    let on = |x: Vector<3>| near(x[0].hypot(x[1]), 3.0);
    same(circle(), &on, 3 * 3);
    same(
        Region::All(vec![circle(), plane(2, 1.0), plane(1, 0.0)]),
        &|x| on(x) && near(x[1], 0.0) && near(x[2], 1.0),
        2,
    );
    same(Region::All(vec![plane(0, 1.0), plane(0, 2.0)]), &|_| false, 0);
}

#[test]
fn an_annulus_holds_both_its_edges() {
    let axis = || Axis::uniform(-6.0, 6.0, 12).unwrap();
    let layout = Layout::on_axes([axis(), axis()]).unwrap();
    let annulus = |inner, outer| Region::<2>::Annulus { centre: [0.0, 0.0], inner, outer };
    let between = |x: Vector<2>| (3.0..=5.0).contains(&x[0].hypot(x[1]));
    assert_eq!(annulus(3.0, 5.0).nodes(&vertices(&layout), &layout), searched(&layout, between));
    assert_eq!(annulus(0.0, 0.9).nodes(&vertices(&layout), &layout).len(), 1);
    assert_eq!(annulus(5.0, 5.0).nodes(&vertices(&layout), &layout).len(), 12);

    let radii = Axis::uniform(5.0, 10.0, 5).unwrap();
    let ring = Layout::<2>::ring([0.0, 0.0], radii, 32, Span::Full, None).unwrap();
    assert_eq!(annulus(6.0, 8.5).nodes(&vertices(&ring), &ring).len(), 3 * 32);
}

#[test]
fn a_ray_holds_one_side_of_its_line() {
    let axis = || Axis::uniform(-6.0, 6.0, 12).unwrap();
    let layout = Layout::on_axes([axis(), axis()]).unwrap();
    let ray = |centre, along| Region::<2>::Ray { centre, along }.nodes(&vertices(&layout), &layout);
    let diagonal = [0.5_f64.sqrt(), -(0.5_f64.sqrt())];
    assert_eq!(ray([1.0, 2.0], diagonal), searched(&layout, |x| x[0] + x[1] == 3.0 && x[0] >= 1.0));
    assert_eq!(ray([1.0, 2.0], [0.0, 1.0]), searched(&layout, |x| x[0] == 1.0 && x[1] >= 2.0));
    assert_eq!(
        ray([1.0, 2.0], [-0.6, -0.8]),
        searched(&layout, |x| x == Vector::from([1.0, 2.0])
            || x == Vector::from([-2.0, -2.0])
            || x == Vector::from([-5.0, -6.0]))
    );

    let radii = Axis::uniform(5.0, 10.0, 5).unwrap();
    let quarter = Span::Sector { from: 0.3, to: 1.2 };
    let ring = Layout::<2>::ring([1.0, 2.0], radii, 9, quarter, None).unwrap();
    let end = Region::Ray { centre: [1.0, 2.0], along: [1.2_f64.cos(), 1.2_f64.sin()] };
    assert_eq!(
        end.nodes(&vertices(&ring), &ring),
        (0..6).map(|k| ring.lattice().node([9, k])).collect::<Vec<_>>()
    );
}

#[test]
fn a_pythagorean_circle_meets_a_square_grid() {
    let axis = || Axis::uniform(-6.0, 6.0, 12).unwrap();
    let layout = Layout::on_axes([axis(), axis()]).unwrap();
    let circle = Region::Circle { centre: [0.0, 0.0], radius: 5.0 };
    assert_eq!(circle.nodes(&vertices(&layout), &layout).len(), 12);
}

#[test]
fn regions_of_a_ring() {
    let radii = Axis::uniform(5.0, 10.0, 5).unwrap();
    let layout = Layout::<2>::ring([1.0, 2.0], radii, 32, Span::Full, None).unwrap();
    let circle = |radius| Region::Circle { centre: [1.0, 2.0], radius };
    let inner = circle(5.0).nodes(&vertices(&layout), &layout);
    assert_eq!(inner.iter().map(|v| v.index()).collect::<Vec<_>>(), (0..32).collect::<Vec<_>>());
    assert_eq!(circle(10.0).nodes(&vertices(&layout), &layout).len(), 32);
    assert!(circle(5.5).nodes(&vertices(&layout), &layout).is_empty());
    // Both half lines of the diameter along x, and one end of it.
    let diameter = Region::Plane { axis: 1, at: 2.0 };
    assert_eq!(diameter.nodes(&vertices(&layout), &layout).len(), 12);
    let ends = Region::All(vec![diameter, circle(10.0)]).nodes(&vertices(&layout), &layout);
    assert_eq!(ends.len(), 2);
    let end = Region::Point(Vector::<2>::new(11.0, 2.0)).nodes(&vertices(&layout), &layout);
    assert_eq!(end, [layout.lattice().node([0, 5])]);
    let half = Region::Box { from: Vector::<2>::new(-99.0, 2.0), to: Vector::<2>::new(99.0, 99.0) };
    assert_eq!(half.nodes(&vertices(&layout), &layout), searched(&layout, |x| x[1] > 2.0 - 1e-10));

    let height = Axis::uniform(0.0, 1.0, 2).unwrap();
    let radii = Axis::uniform(5.0, 10.0, 5).unwrap();
    let layout = Layout::<3>::ring([1.0, 2.0], radii, 8, Span::Full, Some(height)).unwrap();
    let cylinder = Region::Circle { centre: [1.0, 2.0], radius: 5.0 };
    let bottom = Region::Plane { axis: 2, at: 0.0 };
    assert_eq!(cylinder.nodes(&vertices(&layout), &layout).len(), 24);
    assert_eq!(Region::All(vec![cylinder, bottom]).nodes(&vertices(&layout), &layout).len(), 8);
}

#[test]
fn small_regions_of_a_huge_grid_are_cheap() {
    let axis = || Axis::uniform(0.0, 1.0, 1500).unwrap();
    let layout = Layout::on_axes([axis(), axis(), axis()]).unwrap();
    let edge = |a, b| Region::All(vec![Region::Plane { axis: a, at: 0.0 }, Region::Plane { axis: b, at: 1.0 }]);
    // Searching 3.4e9 nodes would take minutes each time.
    for _ in 0..100 {
        assert_eq!(edge(0, 1).nodes(&vertices(&layout), &layout).len(), 1501);
        let corner = Region::Point(Vector::<3>::new(1.0, 1.0, 1.0)).nodes(&vertices(&layout), &layout);
        assert_eq!(corner[0].index(), layout.lattice().n_nodes() - 1);
        let from = Vector::<3>::from_element(0.5);
        let cube = Region::Box { from, to: from.add_scalar(0.01) };
        assert_eq!(cube.nodes(&vertices(&layout), &layout).len(), 16 * 16 * 16);
    }
}

#[test]
fn regions_hold_control_points_by_their_abscissae() {
    let layout = solid();
    let space = NodeSpace::of(NodeKind::ControlPoints { degree: 2 }, &Mesh::at_rest(&layout)).unwrap();
    let [x, y, z] = space.lines(&layout);
    let place = |node| space.position(&Mesh::at_rest(&layout), node);
    let same = |region: Region<3>, holds: &dyn Fn(Vector<3>) -> bool, count: usize| {
        let all = (0..space.lattice().n_nodes()).map(|i| NodeId::from_index(i).unwrap());
        let nodes = region.nodes(&space, &layout);
        assert_eq!(nodes, all.filter(|&node| holds(place(node))).collect::<Vec<_>>(), "{region:?}");
        assert_eq!(nodes.len(), count, "{region:?}");
        assert!(region.candidates(&space, &layout) >= count as f64);
    };
    assert_eq!([x.len(), y.len(), z.len()], [8, 6, 4]);
    let plane = |axis, at| Region::Plane { axis, at };
    same(Region::Everywhere, &|_| true, 8 * 6 * 4);
    same(plane(1, 0.0), &|x| x[1] == 0.0, 8 * 4);
    same(plane(1, 3.0 - 1e-12), &|x| x[1] == 3.0, 8 * 4);
    same(plane(0, -2.5), &|x| near(x[0], -2.5), 6 * 4);
    same(plane(0, -2.0), &|_| false, 0);
    let (from, to) = (Vector::<3>::new(-1.6, 0.0, 2.0), Vector::<3>::new(1.4, f64::INFINITY, 9.0));
    same(Region::Box { from, to }, &|x| x[0] > -1.6 && x[0] < 1.4 && x[2] == 2.0, 3 * 6);
    let circle = Region::Circle { centre: [0.0, 0.0], radius: 3.0 };
    same(circle, &|x| near(x[0].hypot(x[1]), 3.0), 2 * 4);
}
