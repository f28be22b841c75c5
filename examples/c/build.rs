//! Tells the tests whether there is a C compiler, and one for a chip with its emulation: without they are reported as
//! ignored.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(c_compiler, chip_emulated)");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=PATH");
    let found = |program: &str| {
        let out = std::process::Command::new(program)
            .arg("--version")
            .output();
        out.is_ok_and(|out| out.status.success())
    };
    if found("cc") {
        println!("cargo::rustc-cfg=c_compiler");
    }
    if found("arm-none-eabi-gcc") && found("qemu-system-arm") {
        println!("cargo::rustc-cfg=chip_emulated");
    }
}
