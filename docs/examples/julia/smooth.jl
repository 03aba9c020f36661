# smooth: smooth the triangles of a square with displaced nodes by planish, from Julia.
#
#   julia smooth.jl
const lib = get(ENV, "PLANISH_LIBRARY", "libplanish.so.0.2")

struct Mesh # planish_mesh: unused fields are zero
    dim::Cint
    n_nodes::Int64; n_elements::Int64
    coordinates::Ptr{Float64}; elements::Ptr{Int32}
    constraint::Ptr{UInt8}; direction::Ptr{Float64}
    n_periodic::Int64; periodic::Ptr{Int32}
    min_volume::Ptr{Float64}; elements64::Ptr{Int64}
    node_stride::Int64; component_stride::Int64
    neighbours::Ptr{Int32}; neighbours64::Ptr{Int64}
    part::Ptr{Cvoid}; cells::Ptr{Cvoid}
    reference::Ptr{Float64}; is_layer::Ptr{UInt8}; size::Ptr{Float64}; metric::Ptr{Float64}
    reserved::NTuple{8, Ptr{Cvoid}}
end
Mesh(xy, triangles) = Mesh(2, size(xy, 2), size(triangles, 2), pointer(xy), pointer(triangles),
    C_NULL, C_NULL, 0, C_NULL, C_NULL, C_NULL, 0, 0, C_NULL, C_NULL, C_NULL, C_NULL, C_NULL, C_NULL,
    C_NULL, C_NULL, ntuple(_ -> C_NULL, 8))

struct Error # planish_error
    code::Cint
    element::Int64; node::Int64
    text::NTuple{512, UInt8}
end

const problem = Ref(Error(0, 0, 0, ntuple(_ -> 0x00, 512)))
check(status) = status == 0 || error(String(collect(Iterators.takewhile(!iszero, problem[].text))))

function worst(plan, xy, n)
    ratio = zeros(n)
    check(ccall((:planish_measure_elements, lib), Cint, (Ptr{Cvoid}, Ptr{Float64}, Ptr{Float64}, Ref{Error}),
        plan, xy, ratio, problem))
    return round(maximum(ratio), digits = 4)
end

const n = 20 # squares of a side
# Nodes on a grid, inner ones displaced by up to 0.4 of a square, and two triangles for each square.
off(i, j) = i % n == 0 || j % n == 0 ? 0.0 : 0.4
xy = reduce(hcat, [[i + off(i, j) * sin(7i + 13j), j + off(i, j) * cos(2 * (7i + 13j))] for j in 0:n for i in 0:n])
corner = [j * (n + 1) + i for j in 0:n-1 for i in 0:n-1] # nodes are counted from 0
triangles = reduce(hcat, [Int32[k k; k+1 k+n+2; k+n+2 k+n+1] for k in corner])

GC.@preserve xy triangles begin
    mesh, plan = Ref(Mesh(xy, triangles)), Ref{Ptr{Cvoid}}(C_NULL)
    check(ccall((:planish_plan_create, lib), Cint, (Ref{Mesh}, Ptr{Cvoid}, Ref{Ptr{Cvoid}}, Ref{Error}),
        mesh, C_NULL, plan, problem))
    before = worst(plan[], xy, size(triangles, 2))
    check(ccall((:planish_smooth, lib), Cint, (Ptr{Cvoid}, Ptr{Float64}, Ptr{Cvoid}, Ptr{Cvoid}, Ref{Error}),
        plan[], xy, C_NULL, C_NULL, problem))
    println("worst radius ratio $before -> $(worst(plan[], xy, size(triangles, 2)))")
    ccall((:planish_plan_destroy, lib), Cvoid, (Ptr{Cvoid},), plan[])
end
