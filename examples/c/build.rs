//! Tells the tests whether there is a C compiler: without one they are reported as ignored.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(c_compiler)");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=PATH");
    let found = std::process::Command::new("cc").arg("--version").output();
    if found.is_ok_and(|out| out.status.success()) {
        println!("cargo::rustc-cfg=c_compiler");
    }
}
