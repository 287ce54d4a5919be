// SPDX-License-Identifier: MIT
//! Compiles the library, c/mlrt.c, or in a checkout of the repository the one that `make amalgamation` has written.
//!
//! With the feature `system`, links the installed library: pkg-config says where it is, or MLRT_LIB_DIR does.

use std::{env, path::Path, process::Command, process::ExitStatus};

/// Ends the build with a sentence that says what to do.
fn fail(sentence: &str) -> ! {
    println!("cargo:warning={sentence}");
    eprintln!("\n{sentence}\n");
    std::process::exit(1);
}

fn link_installed() {
    println!("cargo:rerun-if-env-changed=MLRT_LIB_DIR");
    println!("cargo:rerun-if-env-changed=PKG_CONFIG_PATH");
    if let Ok(folder) = env::var("MLRT_LIB_DIR") {
        println!("cargo:rustc-link-search=native={folder}");
    } else {
        let answer = Command::new("pkg-config").args(["--libs-only-L", "mlrt"]).output();
        match answer {
            Ok(answer) if ExitStatus::success(&answer.status) => {
                for folder in String::from_utf8_lossy(&answer.stdout).split_whitespace() {
                    println!("cargo:rustc-link-search=native={}", folder.trim_start_matches("-L"));
                }
            }
            _ => fail(
                "mlrt, feature `system`: pkg-config does not know libmlrt. Install the library (make install in its sources) \
                 and set PKG_CONFIG_PATH, or set MLRT_LIB_DIR to the folder of libmlrt.so, or build without the feature.",
            ),
        }
    }
    println!("cargo:rustc-link-lib=mlrt");
}

fn compile() {
    let folders = ["c", "../../build/amalgamation"];
    let Some(folder) = folders.iter().find(|folder| Path::new(folder).join("mlrt.c").exists()) else {
        fail(
            "mlrt: the C library is not here: this is a checkout, not the published crate. Run `make amalgamation` in the \
             repository, or use the feature `system` with an installed library.",
        )
    };
    let file = Path::new(folder).join("mlrt.c");
    println!("cargo:rerun-if-changed={}", file.display());
    let mut build = cc::Build::new();
    // A ray tracer that is not optimised is of no use in a debug build either.
    build.file(file).include(folder).define("NDEBUG", None).opt_level(2).debug(false).std("c99").warnings(false);
    if env::var("CARGO_CFG_TARGET_ARCH").as_deref() == Ok("x86") {
        build.flag("-msse2").flag("-mfpmath=sse");
    }
    if let Err(error) = build.try_compile("mlrt") {
        fail(&format!(
            "mlrt: gcc or clang could not compile the C library: install one of them, or name it in the variable CC, or use the \
             feature `system` with an installed library. {error}"
        ));
    }
    if env::var("CARGO_CFG_TARGET_FAMILY").as_deref() == Ok("unix") {
        println!("cargo:rustc-link-lib=m");
        println!("cargo:rustc-link-lib=pthread");
    }
}

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if env::var_os("CARGO_FEATURE_SYSTEM").is_some() {
        link_installed();
    } else {
        compile();
    }
}
