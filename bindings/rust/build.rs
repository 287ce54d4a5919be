// SPDX-License-Identifier: MIT
//! Makes src/lib.rs' module `ffi` from mlrt.h, with bindgen (which needs libclang), and links libmlrt.
//!
//! pkg-config says where they are, or MLRT_INCLUDE_DIR and MLRT_LIB_DIR do.

use std::{env, path::PathBuf, process::Command};

/// A folder from the environment, else what pkg-config answers to `question` without its -I or -L.
fn folder(variable: &str, question: &str) -> Option<String> {
    println!("cargo:rerun-if-env-changed={variable}");
    env::var(variable).ok().or_else(|| {
        let answer = Command::new("pkg-config").args([question, "mlrt"]).output().ok()?;
        let flags = String::from_utf8(answer.stdout).ok()?;
        Some(flags.trim().get(2..)?.to_string())
    })
}

fn main() {
    println!("cargo:rerun-if-env-changed=PKG_CONFIG_PATH");
    let header =
        folder("MLRT_INCLUDE_DIR", "--cflags-only-I").map_or("/usr/include".into(), PathBuf::from).join("mlrt.h");
    if let Some(libraries) = folder("MLRT_LIB_DIR", "--libs-only-L") {
        println!("cargo:rustc-link-search=native={libraries}");
    }
    println!("cargo:rustc-link-lib=mlrt");
    println!("cargo:rerun-if-changed={}", header.display());

    bindgen::Builder::default()
        .header(header.to_str().expect("a path in UTF-8"))
        .allowlist_item("(mlrt|MLRT)_.*")
        .derive_default(true)
        .generate()
        .expect("bindings from mlrt.h")
        .write_to_file(PathBuf::from(env::var("OUT_DIR").unwrap()).join("mlrt.rs"))
        .expect("a file for the bindings");
}
