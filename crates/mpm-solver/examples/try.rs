use mpm_solver::{compile, observe::*, scene::Scene};
struct P;
impl Observer for P { fn load_step(&mut self, s:&LoadStep<'_>)->Result<(),ObserverError>{ 
 print!("{} {:.4} ", s.index, s.fraction); for e in &s.row[1..] { match e { Entry::Count(c)=>print!("{c:?} "), Entry::Real(r)=>print!("{r:?} ") } } println!("{:?}", s.residuals.iter().map(|r|format!("{r:.1e}")).collect::<Vec<_>>()); 
 let x=s.fields.positions(); let mx=x.chunks(3).map(|c|c[0]).fold(f64::MIN,f64::max); let my=x.chunks(3).map(|c|c[1]).fold(f64::MIN,f64::max); let sy:f64=x.chunks(3).map(|c|c[1]).sum(); println!("   max x {mx:.10} y {my:.10} sum y {sy:.10}"); Ok(()) } }
fn main(){ let t=std::fs::read_to_string(std::env::args().nth(1).unwrap()).unwrap(); let s=Scene::from_ron(&t).unwrap(); let r=compile(&s).unwrap().run(&mut P); println!("{r:?}"); }
