use mpm_solver::{compile, observe::*, scene::*};
use mpm_solver::vortex::Vortex; use mpm_grid::{Ramp, LoadFraction, Vector};
struct P{ e:Vec<(f64,f64)>, its:u64 }
impl Observer for P { fn load_step(&mut self, s:&LoadStep<'_>)->Result<(),ObserverError>{ 
 let at=LoadFraction::new(s.fraction).unwrap(); let x=s.fields.positions(); let u=s.fields.field(Field::Displacement); let sg=s.fields.field(Field::CauchyStress); let vol=s.fields.field(Field::Volume);
 let v=Vortex::new(1e3/2.6, Ramp::linear(14.32394487827058f64.to_radians()));
 let (mut a,mut b,mut c,mut w)=(0.,0.,0.,0.);
 for p in 0..vol.len(){ let r=Vector::<2>::new(x[3*p]-u[3*p],x[3*p+1]-u[3*p+1]); let e=v.position(&r,at); let q=v.stress(&r,at);
  a+=vol[p]*((e[0]-x[3*p]).powi(2)+(e[1]-x[3*p+1]).powi(2)); let d=[sg[9*p]-q[0],sg[9*p+4]-q[1],sg[9*p+1]-q[2]]; b+=vol[p]*(d[0]*d[0]+d[1]*d[1]+2.*d[2]*d[2]); c+=vol[p]*(q[0]*q[0]+q[1]*q[1]+2.*q[2]*q[2]); w+=vol[p]; }
 self.e.push(((a/w).sqrt(),(b/c.max(1e-300)).sqrt())); self.its+=s.residuals.len() as u64; Ok(()) } }
fn main(){ let t=std::fs::read_to_string("scenes/vortex.ron").unwrap(); 
 for basis in [PlaneBasis::Smpm,PlaneBasis::Gimp,PlaneBasis::Cpdi1,PlaneBasis::Cpdi2q,PlaneBasis::Cpdi2t] { for cells in [12u32,24,48,96] {
 let Scene::PlaneStrain(mut s)=Scene::from_ron(&t).unwrap() else {panic!()}; s.basis=basis; if let MeshInput::Box{axes}=&mut s.mesh { for a in axes { if let AxisInput::Uniform{cells:c,..}=a { *c=Count(cells);} } } s.schedule.cuts=4;
 let mut o=P{e:vec![],its:0}; let t0=std::time::Instant::now(); let r=match compile(&Scene::PlaneStrain(s)) {Ok(mut c)=>c.run(&mut o).map_err(|e|e.to_string()),Err(e)=>Err(e.to_string())};
 let l=o.e.last().copied().unwrap_or((0.,0.)); println!("{basis:?} {cells} u-err {:.3e} stress-err {:.3e} steps {} its {} {:.2}s {}", l.0,l.1,o.e.len().max(1)-1,o.its,t0.elapsed().as_secs_f64(), r.map_or_else(|e|e.chars().take(150).collect(),|s|format!("cuts {}",s.cuts))); } } }
