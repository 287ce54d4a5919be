// SPDX-License-Identifier: MIT

//go:build mlrt_system

package mlrt

// The library is the installed one, which pkg-config knows.

// #cgo CFLAGS: -DMLRT_SYSTEM
// #cgo pkg-config: mlrt
import "C"
