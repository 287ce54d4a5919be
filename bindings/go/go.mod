module mlrt

go 1.21
