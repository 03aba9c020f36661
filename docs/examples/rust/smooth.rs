// smooth: smooth the triangles of a square with displaced nodes by planish, from Rust.
//
//   rustc -O smooth.rs -l planish && ./smooth
use std::os::raw::{c_char, c_int, c_void};
use std::ptr::{null, null_mut};

#[repr(C)]
struct Mesh { // planish_mesh: unused fields are zero
    dim: c_int,
    n_nodes: i64, n_elements: i64,
    coordinates: *const f64, elements: *const i32,
    constraint: *const u8, direction: *const f64,
    n_periodic: i64, periodic: *const i32,
    min_volume: *const f64, elements64: *const i64,
    node_stride: i64, component_stride: i64,
    neighbours: *const i32, neighbours64: *const i64,
    part: *const c_void, cells: *const c_void,
    reference: *const f64, is_layer: *const u8, size: *const f64, metric: *const f64,
    reserved: [*const c_void; 8],
}

#[repr(C)]
struct Error { // planish_error
    code: c_int,
    element: i64, node: i64,
    text: [c_char; 512],
}

extern "C" {
    fn planish_plan_create(mesh: *const Mesh, options: *const c_void, plan: *mut *mut c_void, error: *mut Error) -> c_int;
    fn planish_smooth(plan: *mut c_void, xy: *mut f64, options: *const c_void, result: *mut c_void, error: *mut Error) -> c_int;
    fn planish_measure_elements(plan: *const c_void, xy: *const f64, ratio: *mut f64, error: *mut Error) -> c_int;
    fn planish_plan_destroy(plan: *mut c_void);
}

const N: usize = 20; // squares of a side

/// Nodes on a grid, inner ones displaced by up to 0.4 of a square, and two triangles for each square.
fn make_mesh() -> (Vec<f64>, Vec<i32>) {
    let (mut xy, mut triangles) = (vec![], vec![]);
    for j in 0..=N {
        for i in 0..=N {
            let angle = (7 * i + 13 * j) as f64;
            let off = if i % N == 0 || j % N == 0 { 0.0 } else { 0.4 };
            xy.extend([i as f64 + off * angle.sin(), j as f64 + off * (2.0 * angle).cos()]);
        }
    }
    for k in (0..N * N).map(|square| square / N * (N + 1) + square % N) {
        triangles.extend([k, k + 1, k + N + 2, k, k + N + 2, k + N + 1].map(|node| node as i32));
    }
    (xy, triangles)
}

fn main() {
    let (mut xy, triangles) = make_mesh();
    let mut ratio = vec![0.0; triangles.len() / 3];
    let mut worst = [0.0; 2];
    unsafe {
        let (mut mesh, mut error): (Mesh, Error) = std::mem::zeroed();
        let mut plan = null_mut();
        mesh.dim = 2;
        mesh.n_nodes = (xy.len() / 2) as i64;
        mesh.n_elements = ratio.len() as i64;
        mesh.coordinates = xy.as_ptr();
        mesh.elements = triangles.as_ptr();
        let mut status = planish_plan_create(&mesh, null(), &mut plan, &mut error);
        for step in 0..2 {
            if status == 0 && step == 1 {
                status = planish_smooth(plan, xy.as_mut_ptr(), null(), null_mut(), &mut error);
            }
            if status == 0 {
                status = planish_measure_elements(plan, xy.as_ptr(), ratio.as_mut_ptr(), &mut error);
            }
            worst[step] = ratio.iter().copied().fold(0.0, f64::max);
        }
        planish_plan_destroy(plan);
        if status != 0 {
            eprintln!("{}", std::ffi::CStr::from_ptr(error.text.as_ptr()).to_string_lossy());
            std::process::exit(1);
        }
    }
    println!("worst radius ratio {:.4} -> {:.4}", worst[0], worst[1]);
}
