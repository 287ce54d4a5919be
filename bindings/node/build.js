#!/usr/bin/env node
// SPDX-License-Identifier: MIT
/**
 * Compiles the library: `npx mlrt-build`, or on installing the package where it brings none for this machine.
 *
 *     node build.js               mlrt.c, the whole library in one file, and native.c
 *     node build.js --install     the same, but only if no library that the package brings can be used here
 *
 * CC is the compiler, else cc, gcc or clang; CFLAGS replaces -O2. If MLRT_LIBRARY is the path of an installed libmlrt,
 * that is used in place of mlrt.c.
 */
'use strict';
const { spawnSync } = require('node:child_process');
const fs = require('node:fs');
const path = require('node:path');

const out = path.join(__dirname, 'build', 'mlrt.node.so');

/** Whether the library that is here can be used: asked in another process, which leaves this one without it. */
function works() {
    return spawnSync(process.execPath, ['-e', 'require("./native.js")'], { cwd: __dirname }).status === 0;
}

function fail(reason) {
    console.error(`mlrt: ${reason}`);
    process.exit(1);
}

function findCompiler() {
    const names = process.env.CC ? [process.env.CC] : ['cc', 'gcc', 'clang'];
    const found = names.find((name) => spawnSync(name, ['--version']).status === 0);
    return found ?? fail(`no C compiler (${names.join(', ')}): install gcc or clang, or name one in CC; then run "npx mlrt-build"`);
}

function compile() {
    const compiler = findCompiler();
    const installed = process.env.MLRT_LIBRARY;
    const flags = (process.env.CFLAGS ?? '-O2').split(/\s+/).filter(Boolean);
    const machine = process.arch === 'ia32' && process.platform !== 'win32' ? ['-msse2', '-mfpmath=sse'] : [];
    const position = process.platform === 'win32' ? ['-DMLRT_BUILD_DLL'] : ['-fPIC'];
    const library = installed ? [installed, `-Wl,-rpath,${path.dirname(path.resolve(installed))}`] : ['mlrt.c'];
    const own = `${out}.${process.pid}`; // moved into place once it is whole
    fs.mkdirSync(path.dirname(out), { recursive: true });
    const call = [...flags, ...machine, ...position, '-shared', '-I.', 'native.c', ...library, '-lm', '-pthread', '-o', own];
    const { status, stderr } = spawnSync(compiler, call, { cwd: __dirname, encoding: 'utf8' });
    if (status !== 0) fail(`${compiler} cannot compile the library:\n${stderr}`);
    fs.renameSync(own, out);
    if (!works()) fail(`${out} was compiled, but cannot be loaded: try require("mlrt")`);
    console.log(`mlrt: compiled ${out}, ${fs.statSync(out).size} bytes`);
}

if (!process.argv.includes('--install') || !works()) compile();
