module github.com/libmlrt/libmlrt/bindings/go

go 1.21
