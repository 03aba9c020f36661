# A file of Gmsh 2.2 with a point element before the others for every node whose number is a multiple
# of every.
$0 == "$Nodes" { getline; n_nodes = $1; print "$Nodes" }
$0 == "$Elements" {
    getline
    added = int(n_nodes / every)
    print "$Elements"
    print $1 + added
    for (i = 1; i <= added; i++)
        print 100000 + i, 15, 2, 0, i, i * every
    next
}
{ print }
